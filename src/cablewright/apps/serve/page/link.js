// The connection: the latest state comes, orders go. It is made again when it is lost; nothing is kept to be sent later.
import { t } from "./words.js";

const AGAIN = 500; // ms
export const STALE = 500; // ms, from which a state is old

export class Link {
  constructor() {
    this.heard = { hello: [], sitting: [], state: [], lease: [], answer: [], jog: [], lost: [] };
    this.seen = -Infinity; // ms, when the last state came
    this.age = Infinity; // ms, how old it was then
    this.beat = 0;
    this.count = 0;
    this.waiting = new Map();
    this.open();
    setInterval(() => this.send({ t: "beat" }), 1000);
  }

  on(kind, act) { this.heard[kind].push(act); return this; }

  tell(kind, message) { for (const act of this.heard[kind]) act(message); }

  open() {
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    this.socket = socket;
    socket.addEventListener("message", ({ data }) => this.take(JSON.parse(data)));
    socket.addEventListener("close", () => {
      for (const done of this.waiting.values()) done(t("link.lost"));
      this.waiting.clear();
      this.tell("lost", null);
      setTimeout(() => this.again(), AGAIN);
    });
  }

  async again() { // an expired token is requested again
    const answer = await fetch("/runs", { method: "HEAD" }).catch(() => null);
    if (answer?.status === 401) location.replace("/enter");
    else this.open();
  }

  take(message) {
    if (message.t === "state") {
      this.seen = performance.now();
      this.age = 1e3 * message.age;
      this.beat = message.beat;
    } else if (message.t === "hello") this.page = message.page;
    else if (message.t === "answer") {
      this.waiting.get(message.id)?.(message.refusal);
      this.waiting.delete(message.id);
    }
    this.tell(message.t, message);
  }

  get stale() { return !this.live || performance.now() - this.seen + this.age > STALE; }

  get live() { return this.socket.readyState === WebSocket.OPEN; }

  send(message) {
    if (this.live) this.socket.send(JSON.stringify(message));
    return this.live;
  }

  order(kind, args = {}) { // answers why not; an empty text: it was obeyed
    const id = ++this.count;
    if (!this.send({ t: "order", id, beat: this.beat, kind, arguments: args })) return Promise.resolve(t("link.none"));
    return new Promise((done) => this.waiting.set(id, done));
  }

  async stop() { // by both connections; whether one of them succeeded
    const sent = this.send({ t: "stop" });
    const answer = await fetch("/stop", { method: "POST" }).catch(() => null);
    return Boolean(answer?.ok) || (sent && !this.stale);
  }

  async ask(path, options = {}) { // of an operator; throws the server's error text
    const headers = { "x-page": this.page ?? "", ...options.headers };
    const answer = await fetch(path, { ...options, headers }).catch(() => null);
    if (!answer) throw new Error(t("link.silent"));
    if (!answer.ok) throw new Error((await answer.text()).trim() || t("link.refused", { status: answer.status }));
    return answer.json();
  }
}
