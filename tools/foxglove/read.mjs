// Reads a live log by Foxglove's reference client, and prints its topics: `npm ci && node read.mjs ADDRESS SECONDS`.
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { FoxgloveClient } = protocol; // a CommonJS module
const [address, seconds] = process.argv.slice(2);
const client = new FoxgloveClient({ ws: new WebSocket(address, [process.argv[4] ?? FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const decoder = new TextDecoder(), names = new Map(), found = {};
client.on("error", (reason) => { console.error(String(reason)); process.exit(1); });
client.on("advertise", (channels) => {
  for (const channel of channels) {
    found[channel.topic] = { schema: channel.schemaName, encoding: channel.encoding, messages: 0, last: null };
    names.set(client.subscribe(channel.id), channel.topic);
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const own = found[names.get(subscriptionId)];
  own.messages++;
  own.last = JSON.parse(decoder.decode(data));
  own.time = Number(timestamp) / 1e9;
});
setTimeout(() => {
  console.log(JSON.stringify(found));
  client.close();
  process.exit(0);
}, 1e3 * Number(seconds));
