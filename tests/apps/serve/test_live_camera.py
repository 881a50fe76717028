"""Pictures of a camera in the network: stills and the first picture of a stream, whole or not at all."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import pytest

from cablewright.apps.serve import camera_folder
from cablewright.foundation.errors import EnvironmentFault


@contextmanager
def live_camera(kind: str, content: bytes, **more: str) -> Iterator[str]:
    """A camera in the network, with *more* headers: its address."""

    class Answer(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("content-type", kind)
            for name, value in more.items():
                self.send_header(name.replace("_", "-"), value)
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *args: Any) -> None:
            pass

    server = HTTPServer(("127.0.0.1", 0), Answer)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/snapshot"
    server.shutdown()
    server.server_close()


def test_a_picture_comes_from_the_live_camera() -> None:
    jpeg = b"\xff\xd8\xff\xe0 a picture \xff\xd9"
    with live_camera("image/jpeg", jpeg) as address:
        assert camera_folder.picture_from(address) == jpeg
    part = b"--frame\r\ncontent-type: image/jpeg\r\n\r\n" + jpeg
    with live_camera("multipart/x-mixed-replace; boundary=frame", 3 * part) as address:
        assert camera_folder.picture_from(address) == jpeg
    with pytest.raises(EnvironmentFault, match="the camera does not answer"):
        camera_folder.picture_from(address)


def test_a_picture_of_the_live_camera_is_whole() -> None:
    """A thumbnail's end is not that of its picture; what is cut off is none."""
    jpeg = b"\xff\xd8\xff\xe1 a thumbnail \xff\xd8\xff\xd9 a picture \xff\xd9"
    stream = "multipart/x-mixed-replace; boundary=--frame"
    head = b"--frame\r\nContent-Type: image/jpeg\r\n"
    for part in (head + b"\r\n" + jpeg + b"\r\n", head + b"Content-Length: %d\r\n\r\n" % len(jpeg) + jpeg + b"\r\n"):
        with live_camera(stream, 2 * part) as address:
            assert camera_folder.picture_from(address) == jpeg
        rejected(part[: -len(b" a picture ..")], stream)
    rejected(jpeg[:20], content_length=str(len(jpeg)))
    rejected(b"14\r\nshort", transfer_encoding="chunked", words="the camera does not answer")


def rejected(
    content: bytes, kind: str = "image/jpeg", words: str = "ended before a picture was whole", **more: str
) -> None:
    with live_camera(kind, content, **more) as address, pytest.raises(EnvironmentFault, match=words):
        camera_folder.picture_from(address)
