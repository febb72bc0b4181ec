// Joins PNG files of one size and kind into an animated PNG, which every browser shows; their pixels are copied as they are.
//
//     build/release/server/tetfront render assets/scenes/bunny.json --frames 40 --fps 20 --size 360x270 --out frames
//     node tests/browser/animate.mjs frames assets/pictures/bunny_moves.png 20

import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [folder, file, rate] = [process.argv[2], process.argv[3], Number(process.argv[4] ?? 20)];
if (!folder || !file || !(rate > 0)) {
  console.error("usage: node tests/browser/animate.mjs FOLDER FILE.png [FRAMES_PER_SECOND]");
  process.exit(2);
}

/** The chunks of a PNG: name and data. */
function chunks(bytes) {
  const list = [];
  for (let at = 8; at < bytes.length;) {
    const size = bytes.readUInt32BE(at);
    list.push({ name: bytes.toString("latin1", at + 4, at + 8), data: bytes.subarray(at + 8, at + 8 + size) });
    at += 12 + size;
  }
  return list;
}

function chunk(name, data) {
  const body = Buffer.concat([Buffer.from(name, "latin1"), data]);
  return Buffer.concat([number(data.length), body, number(crc32(body))]);
}

const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n;
});
const crc32 = (bytes) => (bytes.reduce((crc, byte) => TABLE[(crc ^ byte) & 255] ^ (crc >>> 8), -1) ^ -1) >>> 0;

function number(value) {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32BE(value);
  return bytes;
}

const names = readdirSync(folder)
  .filter((name) => name.endsWith(".png"))
  .sort();
if (names.length === 0) throw new Error(`${folder} has no .png files`);
const pictures = names.map((name) => chunks(readFileSync(join(folder, name))));
const header = pictures[0].find(({ name }) => name === "IHDR").data;
let sequence = 0;
const frames = pictures.flatMap((picture, i) => {
  const own = picture.find(({ name }) => name === "IHDR").data;
  if (!own.equals(header)) throw new Error(`${names[i]} has another size or kind than ${names[0]}`);
  const control = Buffer.alloc(26); // no offset, no disposal, no blending
  control.writeUInt32BE(sequence++, 0);
  header.copy(control, 4, 0, 8); // width and height
  control.writeUInt16BE(1, 20);
  control.writeUInt16BE(rate, 22);
  const data = picture.filter(({ name }) => name === "IDAT").map(({ data: part }) => part);
  const out = [chunk("fcTL", control)];
  for (const part of data)
    out.push(i === 0 ? chunk("IDAT", part) : chunk("fdAT", Buffer.concat([number(sequence++), part])));
  return out;
});
const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
const control = Buffer.concat([number(pictures.length), number(0)]); // forever
writeFileSync(
  file,
  Buffer.concat([signature, chunk("IHDR", header), chunk("acTL", control), ...frames, chunk("IEND", Buffer.alloc(0))]),
);
