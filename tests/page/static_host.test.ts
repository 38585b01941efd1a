// The page on a plain web server, below a path: `cargo xtask dist`.
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { FileServer } from './file_server.ts';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';

const site = process.env.SLAMLAB_DIST ?? fileURLToPath(new URL('../../target/dist', import.meta.url));
test.skip(!existsSync(`${site}/index.html`), `no page in ${site}: cargo xtask dist makes one`);

const BELOW = '/a/b/';

test('the page runs below a path of a plain server, with nothing from elsewhere', async ({ lab, page }) => {
  const server = await FileServer.start(site, BELOW);
  await lab.open(`${server.origin}${BELOW}`);
  await lab.watch((s) => s.features, 'the robot maps').toBeGreaterThan(2);
  // Each file that is loaded only on demand.
  await drop(page, 'flat.svg', Buffer.from(`<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1"><polygon points="0,0 5,0 5,4 0,4" fill="none" stroke="black"/></svg>`));
  await expect.poll(async () => (await lab.state()).title, 'the module of files').toBe('flat.svg');
  await page.keyboard.press('l');
  await expect(page.locator('slam-registration').getByTestId('lab-reset'), 'the registration lab').toBeVisible();
  await page.keyboard.press('Escape');

  await lab.show('run');
  await lab.at('elsewhere').locator('summary').click();
  await expect(lab.at('no-bridge')).toContainText('no bridge can be reached from it');
  expect(server.asked.filter((path) => !path.startsWith(BELOW))).toEqual([]);
  await server.stop();
});

test('what no header forbids there, the page forbids itself', async ({ lab, page, problems }) => {
  const server = await FileServer.start(site, BELOW);
  await lab.open(`${server.origin}${BELOW}`);
  const refused = await page.evaluate(async () => {
    const violations: string[] = [];
    addEventListener('securitypolicyviolation', ({ effectiveDirective }) => violations.push(effectiveDirective));
    const script = document.createElement('script');
    script.textContent = 'window.inline = true';
    document.head.append(script);
    await fetch('http://127.0.0.2:9/elsewhere').catch(() => undefined);
    await new Promise((done) => setTimeout(done, 100));
    return { violations: violations.sort(), inline: 'inline' in window };
  });
  expect(refused).toEqual({ violations: ['connect-src', 'script-src-elem'], inline: false });
  expect(problems.every((problem) => /Content Security Policy|elsewhere/.test(problem)), problems.join('\n')).toBe(true);
  problems.length = 0;
  await server.stop();
});

test('a person is told what serves the page', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('elsewhere').locator('summary').click();
  await expect(lab.at('no-bridge')).toContainText('a bridge that has no robot');
});
