// Arrays of a scene: {"type", "shape", "delta", "data"}, where data is base64 of the array's bytes, deflated.
const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array };

export async function unpacked(packed) {
  if (!packed) return null;
  const stream = new Blob([bytes(packed.data)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const values = new TYPES[packed.type](await new Response(stream).arrayBuffer());
  if (packed.delta) undo(values, packed.shape);
  return { values, shape: packed.shape };
}

// Every number was replaced by its difference from the one a row above; a typed array wraps as the differences did.
function undo(values, shape) {
  const row = shape.slice(1).reduce((product, size) => product * size, 1);
  for (let i = row; i < values.length; i++) values[i] += values[i - row];
}

function bytes(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const plain = atob(text), made = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i++) made[i] = plain.charCodeAt(i);
  return made;
}
