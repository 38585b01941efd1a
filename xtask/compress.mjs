// Puts name.br and name.gz beside each file of a folder that compression makes smaller, skips those
// that are up to date, and removes those whose file is gone. The bridge sends them to browsers that
// accept them.
import { readFileSync, readdirSync, rmSync, statSync, existsSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { brotliCompressSync, constants, gzipSync } from 'node:zlib';

const [folder = '.'] = process.argv.slice(2);
const COMPRESSED = /\.(br|gz)$/;
const PACKED_ALREADY = /\.(png|jpe?g|webp|woff2|zip)$/;
const SMALLEST = 1024; // bytes; below one network packet there is nothing to win

const codecs = {
  // The highest quality: 12 % smaller than quality 9 for the module, in 7 s instead of 0.5.
  '.br': (data) => brotliCompressSync(data, { params: {
    [constants.BROTLI_PARAM_QUALITY]: constants.BROTLI_MAX_QUALITY,
    [constants.BROTLI_PARAM_SIZE_HINT]: data.length,
  } }),
  '.gz': (data) => gzipSync(data, { level: 9 }),
};

const files = readdirSync(folder, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile())
  .map((entry) => join(entry.parentPath ?? entry.path, entry.name));

for (const file of files) {
  if (COMPRESSED.test(file)) {
    if (!existsSync(file.replace(COMPRESSED, ''))) rmSync(file);
    continue;
  }
  for (const [ending, pack] of Object.entries(codecs)) {
    const packed = file + ending;
    if (existsSync(packed) && statSync(packed).mtimeMs >= statSync(file).mtimeMs) continue;
    const data = readFileSync(file);
    const result = data.length >= SMALLEST && !PACKED_ALREADY.test(file) ? pack(data) : data;
    if (result.length < data.length) writeFileSync(packed, result);
    else rmSync(packed, { force: true });
  }
}
