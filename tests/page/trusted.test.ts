// A bridge that uses TLS with its own authority, as seen by a browser with this authority and one
// without, and by OpenSSL, which Node uses.
import { execFile } from 'node:child_process';
import { mkdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { connect } from 'node:tls';
import { promisify } from 'node:util';
import { chromium } from '@playwright/test';
import { behind, expect } from './robot_behind.ts';
import { Lab } from './lab.ts';

const run = promisify(execFile);

const test = behind(() => ['--tls', '--source', 'sim:office,lidar']);

test('a browser that has the authority shows the page as secure, and the robot comes over TLS', async ({ folder, bridge, launchOptions }) => {
  test.skip(process.platform !== 'linux', 'only on Linux does Chromium read what it trusts from a folder of its own');
  const database = join(folder, '.pki/nssdb');
  await mkdir(database, { recursive: true });
  const certutil = await run('certutil', ['-N', '-d', `sql:${database}`, '--empty-password']).catch((error: NodeJS.ErrnoException) => error);
  test.skip('code' in certutil && certutil.code === 'ENOENT', 'certutil is missing (Debian: libnss3-tools): Chromium cannot be given an authority');
  await run('certutil', ['-A', '-d', `sql:${database}`, '-t', 'C,,', '-n', 'slamlab', '-i', join(folder, 'tls-ca.pem')]);
  expect(bridge.url).toMatch(/^https:/);
  const browser = await chromium.launch({ ...launchOptions, env: { ...process.env, HOME: folder } as Record<string, string> });
  try {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    await page.addInitScript(() => localStorage.setItem('slamlab-visited', '1'));
    const cdp = await page.context().newCDPSession(page);
    const states: string[] = [];
    cdp.on('Security.visibleSecurityStateChanged', ({ visibleSecurityState }) => states.push(visibleSecurityState.securityState));
    await cdp.send('Security.enable');
    const lab = new Lab(page);
    await lab.open(bridge.url);
    await expect.poll(async () => (await lab.state()).source).toBe('bridge');
    await lab.watch((s) => s.scans, 'scans come').toBeGreaterThan(5);
    await expect.poll(() => states.at(-1)).toBe('secure');
    expect(await page.evaluate(() => isSecureContext)).toBe(true);
  } finally {
    await browser.close();
  }
});

test('a browser that has not the authority shows no page', async ({ bridge, page, problems }) => {
  await expect(page.goto(bridge.url)).rejects.toThrow(/ERR_CERT_AUTHORITY_INVALID/);
  problems.length = 0;
});

test('OpenSSL takes the certificate of who has the authority, by name and by address', async ({ folder, bridge }) => {
  const ca = await readFile(join(folder, 'tls-ca.pem'));
  const verdict = (host: string, authority?: Buffer): Promise<string> => new Promise((resolve) => {
    const socket = connect({ host: '127.0.0.1', port: Number(bridge.port), servername: host === '127.0.0.1' ? '' : host, ...(authority ? { ca: authority } : {}), rejectUnauthorized: true });
    socket.once('secureConnect', () => {
      resolve('taken');
      socket.destroy();
    });
    socket.once('error', (error: NodeJS.ErrnoException) => resolve(error.code ?? error.message));
  });
  expect(await verdict('localhost', ca)).toBe('taken');
  expect(await verdict('127.0.0.1', ca)).toBe('taken');
  expect(await verdict('localhost')).toMatch(/UNABLE_TO_VERIFY|SELF_SIGNED/);
  expect(await verdict('example.com', ca)).toBe('ERR_TLS_CERT_ALTNAME_INVALID');
});
