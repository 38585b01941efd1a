// The page as a user uses it: the built page, served by the real bridge, in an installed Chromium.
// `cargo xtask test page` builds both and sets CHROME and SLAMLAB_BRIDGE; no browser is ever
// downloaded.
//
// | tag of a test | where it runs |
// |---|---|
// | none | at desktop size |
// | `@phone` | there and on a phone: touch, tabs or layout differ |
// | `@phone-only` | on a phone |
import { existsSync } from 'node:fs';
import { delimiter, join } from 'node:path';
import { defineConfig } from '@playwright/test';

const inPath = (name: string) => (process.env.PATH ?? '').split(delimiter).map((folder) => join(folder, name)).find(existsSync);

export default defineConfig({
  testDir: '.',
  testMatch: '*.test.ts',
  outputDir: 'results',
  globalSetup: './bridge.ts',
  forbidOnly: !!process.env.CI,
  // A busy CI machine may starve a browser now and then; a test that needs another attempt is
  // reported as flaky, not hidden.
  retries: process.env.CI ? 2 : 0,
  // Two cores: two simulating pages at once would starve each other and make times meaningless.
  workers: 1,
  timeout: process.env.CI ? 120_000 : 60_000,
  expect: { timeout: process.env.CI ? 30_000 : 15_000 },
  reporter: [['list'], ['./skips.ts']],
  use: {
    browserName: 'chromium',
    launchOptions: {
      executablePath: process.env.CHROME ?? inPath('chromium') ?? 'chromium',
      args: [
        '--no-sandbox', '--disable-gpu', '--disable-quic', '--disable-dev-shm-usage', '--no-first-run',
        '--disable-background-networking', '--disable-component-update', '--disable-sync',
      ],
    },
    screenshot: 'only-on-failure',
  },
  projects: [
    { name: 'desktop', grepInvert: /@phone-only/, use: { viewport: { width: 1280, height: 800 } } },
    { name: 'phone', grep: /@phone/, use: { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true } },
  ],
});
