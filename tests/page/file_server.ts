// A plain file server, like any web host: no special headers, no compression, types by file
// extension, 404 for missing files.
import { readFile } from 'node:fs/promises';
import { createServer, type Server } from 'node:http';
import type { AddressInfo } from 'node:net';
import { extname, join, normalize, sep } from 'node:path';

const TYPES: Readonly<Record<string, string>> = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css', '.json': 'application/json', '.svg': 'image/svg+xml', '.png': 'image/png',
  '.wasm': 'application/wasm', '.woff2': 'font/woff2', '.webmanifest': 'application/manifest+json',
};

export class FileServer {
  /** Requested paths, in order. */
  readonly asked: string[] = [];

  private constructor(private readonly server: Server) {}

  /** Serves the folder below this path, on a port chosen by the system or on the given one. */
  static async start(folder: string, below = '/', port = 0): Promise<FileServer> {
    const server = createServer((request, response) => void (async () => {
      const { pathname } = new URL(request.url ?? '/', 'http://localhost');
      started.asked.push(pathname);
      const name = pathname.startsWith(below) ? normalize(decodeURIComponent(pathname.slice(below.length)) || 'index.html') : '..';
      try {
        if (name === '..' || name.startsWith(`..${sep}`)) throw new Error('outside');
        const bytes = await readFile(join(folder, name));
        response.writeHead(200, { 'content-type': TYPES[extname(name)] ?? 'application/octet-stream' });
        response.end(request.method === 'HEAD' ? undefined : bytes);
      } catch {
        response.writeHead(404, { 'content-type': 'text/plain' });
        response.end('not here\n');
      }
    })());
    const started = new FileServer(server);
    await new Promise<void>((listening) => server.listen(port, '127.0.0.1', listening));
    return started;
  }

  get port(): number {
    return (this.server.address() as AddressInfo).port;
  }

  get origin(): string {
    return `http://127.0.0.1:${this.port}`;
  }

  async stop(): Promise<void> {
    if (!this.server.listening) return;
    const closed = new Promise((done) => this.server.close(done));
    this.server.closeAllConnections();
    await closed;
  }
}
