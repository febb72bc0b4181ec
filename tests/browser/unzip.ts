// Reads a zip archive of stored files by its table of contents, as programs that unpack do. Checksums are left
// to what the pictures have of their own.

export function unzip(archive: Buffer): { name: string; bytes: Buffer }[] {
  const end = archive.length - 22;
  if (archive.readUInt32LE(end) !== 0x06054b50) throw new Error("the archive has no end: it is not whole");
  const files = [];
  let at = archive.readUInt32LE(end + 16);
  for (let i = 0; i < archive.readUInt16LE(end + 10); ++i) {
    if (archive.readUInt32LE(at) !== 0x02014b50) throw new Error(`entry ${i} is none`);
    const [length, offset] = [archive.readUInt16LE(at + 28), archive.readUInt32LE(at + 42)];
    const name = archive.toString("ascii", at + 46, at + 46 + length);
    const start = offset + 30 + archive.readUInt16LE(offset + 26) + archive.readUInt16LE(offset + 28);
    const bytes = archive.subarray(start, start + archive.readUInt32LE(at + 20));
    files.push({ name, bytes });
    at += 46 + length;
  }
  return files;
}
