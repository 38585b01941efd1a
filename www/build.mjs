// Bundles the page into dist/.
import { cpSync, mkdirSync, rmSync } from 'node:fs';
import { build } from 'esbuild';

rmSync('dist', { recursive: true, force: true });
mkdirSync('dist');
await build({ entryPoints: ['src/main.ts', 'src/worker.ts'], bundle: true, format: 'esm', target: 'es2022', minify: true, outdir: 'dist' });
for (const file of ['index.html', 'pkg/slamlab_web_bg.wasm']) cpSync(file, `dist/${file.replace('pkg/', '')}`);
