// Reads a log as Foxglove does: by its own MCAP library, each message held against its own schemas: `node log.mjs FILE`.
import { open } from "node:fs/promises";
import schemas from "@foxglove/schemas/jsonschema.js"; // a CommonJS module
import zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader } from "@mcap/core";
import Ajv from "ajv";

const file = await open(process.argv[2]), { size } = await file.stat();
const readable = {
  size: async () => BigInt(size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length)), { bytesRead } = await file.read(bytes, 0, Number(length), Number(offset));
    if (bytesRead !== bytes.length) throw new Error(`${process.argv[2]}: is shorter than its index says`);
    return bytes;
  },
};
await zstd.isLoaded;
const decompressHandlers = { zstd: (bytes, length) => zstd.decompress(bytes, Number(length)) };
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const ajv = new Ajv({ strict: false, validateFormats: false, formats: { time: true } }), found = {};
const checks = new Map(), decoder = new TextDecoder();
for await (const { channelId, logTime, data } of reader.readMessages()) {
  const { topic, schemaId, messageEncoding } = reader.channelsById.get(channelId), { name } = reader.schemasById.get(schemaId);
  const own = found[topic] ??= { schema: name, encoding: messageEncoding, messages: 0, wrong: null, first: null, last: null };
  const [, kind] = name.split("foxglove.");
  if (kind && !checks.has(kind)) checks.set(kind, ajv.compile(schemas[kind]));
  const content = JSON.parse(decoder.decode(data)), check = checks.get(kind);
  if (check && !check(content)) own.wrong ??= ajv.errorsText(check.errors);
  own.messages++;
  own.first ??= content;
  own.last = content;
  own.time = Number(logTime) / 1e9;
}
await file.close();
console.log(JSON.stringify(found));
