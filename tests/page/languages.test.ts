// Each language from the first visit to a lesson: no text of the catalogue is shown in English,
// nothing overflows, and a run goes on when the language changes.
import { AxeBuilder } from '@axe-core/playwright';
import type { Page } from '@playwright/test';
import * as cs from '../../www/src/words/cs.ts';
import * as hu from '../../www/src/words/hu.ts';
import * as pl from '../../www/src/words/pl.ts';
import { Translator } from '../../www/src/words/translator.ts';
import { expect, test } from './fixture.ts';
import { drop, type Panel } from './lab.ts';

const LANGUAGES = { hu, cs, pl } as const;
/** Words that occur in no other language; names of files, papers and programs may contain them. */
const ENGLISH = /(?<![\p{L}-])(the|of|and|with|which|where|from|this|that|are|for|not|its)(?![\p{L}-])/u;
/** Texts that are the same in every language. */
const NAMES = /Neira|RRT|evaluate --truth|slamlab-bridge|Web Serial|ROS|gmapping|pure pursuit|CARMEN|Fox, Burgard|corrupt gzip stream/;

/** One example of each common error in files and links. */
const WRONG_FILES: readonly [name: string, bytes: string | Buffer][] = [
  ['photo.log', Buffer.from([0xff, 0xd8, 0xff, 0xe0, 0, 16])],
  ['drive.bag', 'SQLite format 3\0'],
  ['page.clf', '<!doctype html><title>404</title>'],
  ['empty.log', ''],
  ['notes.log', 'ODOM 0 0 0 0 0 0 1 host 1\nhello\n'],
  ['letter.slamlab', 'a letter'],
  ['broken.gz', Buffer.from([0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 1])],
  ['list.json', '{ "slamlab_world": 1, "name": "x", "start": { "x": "one", "y": 1 }, "obstacles": [] }'],
];
const WRONG_LINKS = ['run&world=moon&sensor=lidar&method=line-ekf&seed=7', 'run&world=office', 'run&world=office&sensor=nose&method=line-ekf&seed=7', 'run&world=office&sensor=lidar&method=line-ekf&seed=99999999999'];

/** All texts of the page, including attributes that are read aloud. */
const told = (page: Page): Promise<string[]> => page.evaluate(() => {
  const texts: string[] = [];
  const visit = (root: ParentNode) => {
    for (const element of root.querySelectorAll('*')) {
      if (element.matches('style, script, noscript, option[lang]')) continue;
      for (const name of ['title', 'aria-label', 'aria-description', 'placeholder']) {
        const text = element.getAttribute(name);
        if (text) texts.push(text);
      }
      for (const node of element.childNodes) if (node.nodeType === Node.TEXT_NODE && node.textContent?.trim()) texts.push(node.textContent.trim().replace(/\s+/g, ' '));
      if (element.shadowRoot) visit(element.shadowRoot);
    }
  };
  visit(document);
  return [...new Set(texts)];
});

for (const [code, { SAID, HEARD }] of Object.entries(LANGUAGES)) {
  const table: Readonly<Record<string, unknown>> = { ...SAID, ...HEARD };
  /** No visible text is a sentence of the catalogue, or reads like English. */
  const isTranslated = async (page: Page, place: string): Promise<void> => {
    const words = (await told(page)).filter((text) => !NAMES.test(text));
    const left = words.filter((text) => (Object.hasOwn(table, text) && table[text] !== text) || ENGLISH.test(text));
    expect(left, `${code}: English is left in ${place}`).toEqual([]);
  };

  test.describe(`in ${code}`, () => {
    test.use({ firstVisit: true, locale: code });

    test('from the first visit to a lesson no English is left', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
      test.setTimeout(240_000);
      await lab.open();
      await expect(page.locator('html')).toHaveAttribute('lang', code);
      for (const step of ['unknown', 'wheels', 'doubt']) {
        await isTranslated(page, `the tour, ${step}`);
        await lab.at('tour-next').click();
      }
      await isTranslated(page, 'the end of the tour');
      await lab.at('tour-leave').click();
      for (const panel of ['status', 'run', 'plots', 'filter', 'paths', 'log', 'layers'] satisfies Panel[]) {
        await lab.show(panel);
        await isTranslated(page, panel);
      }
      await lab.show('settings');
      await lab.at('settings-all').check();
      await isTranslated(page, 'all settings');
      if (isMobile) await lab.hidePanels();
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 'nothing reaches over the edge').toBeLessThanOrEqual(0);

      await lab.at('help').click();
      await isTranslated(page, 'the help');
      await page.keyboard.press('Escape');
      await lab.at('show-gallery').click();
      await isTranslated(page, 'the gallery');
      await lab.at('lesson-shy').click();
      await expect(lab.at('lesson')).toBeVisible();
      await lab.watch((s) => s.scans, 'the lesson runs').toBeGreaterThan(3);
      await isTranslated(page, 'a lesson');
      await page.keyboard.press('p');
      const { violations } = await new AxeBuilder({ page }).analyze();
      expect(violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id }) => id)).toEqual([]);
    });

    test('what is wrong with a file or a link is said in it', async ({ lab, page }) => {
      await lab.open();
      await lab.at('tour-leave').click();
      for (const [name, bytes] of WRONG_FILES) {
        await drop(page, name, Buffer.from(bytes));
        await expect(lab.at('toast')).toContainText(name);
        await isTranslated(page, `what is wrong with ${name}`);
      }
      for (const link of WRONG_LINKS) {
        await lab.at('toast-close').click();
        await expect(lab.at('toast')).toBeHidden();
        await page.evaluate((link) => (location.hash = link), link);
        await expect(lab.at('toast')).toBeVisible();
        await isTranslated(page, `what is wrong with ${link}`);
      }
    });
  });
}

test('the language changes in the middle of a run, which goes on, and is kept', async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'the run is under way').toBeGreaterThan(5);
  const before = await lab.status();
  await lab.at('help').click();
  await lab.at('language').selectOption('hu');
  await expect(page.locator('html')).toHaveAttribute('lang', 'hu');
  await expect(lab.at('help-dialog')).toContainText('Egy robot, amely még sosem járt itt');
  await page.keyboard.press('Escape');
  const after = await lab.status();
  expect(after.scans, 'nothing began anew').toBeGreaterThanOrEqual(before.scans);
  expect(after.time).toBeGreaterThanOrEqual(before.time);
  await lab.watch((s) => s.scans, 'and it goes on').toBeGreaterThan(after.scans);
  await page.reload();
  await expect(lab.at('stop')).toContainText('ÁLLJ');
  await lab.at('help').click();
  await lab.at('language').selectOption('en');
  await expect(lab.at('stop')).toContainText('STOP');
  await expect(page.locator('html')).toHaveAttribute('lang', 'en');
});

test('a link may name the language, which is not kept', async ({ lab, page }) => {
  await lab.open('/?lang=pl');
  await expect(page.locator('html')).toHaveAttribute('lang', 'pl');
  // Requests under way would be aborted.
  await page.waitForLoadState('networkidle');
  await lab.open('/');
  await expect(page.locator('html')).toHaveAttribute('lang', 'en');
  await page.waitForLoadState('networkidle');
  await lab.open('/?lang=xx');
  await expect(page.locator('html')).toHaveAttribute('lang', 'en');
});

test('forms follow the number, places its sentence, and marks the language', () => {
  const forms = { by: 0, one: '{0} sken', few: '{0} skeny', many: '{0} skenu', other: '{0} skenů' } as const;
  const czech = new Translator('cs', { '{0} scans': forms, '{0} of {1}': '{1}: {0}', east: 'východ', '{0} m to the {1}': '{0} m na {1}', 'goal reached': 'cíl dosažen' }, ['{0} m to the {1}']);
  const scans = (count: number | string) => czech.compose(['', ' scans'], [count]);
  expect([1, 3, 5, 0, '1,5', 22].map(scans)).toEqual(['1 sken', '3 skeny', '5 skenů', '0 skenů', '1,5 skenu', '22 skenů']);
  expect(czech.compose(['', ' of ', ''], [2, 'east'])).toBe('východ: 2');
  // A message of worker or core: recognised by its sentence, with the decimal mark of the language.
  expect(czech.say('3.2 m to the east')).toBe('3,2 m na východ');
  expect(czech.say('Goal reached'), 'at the beginning of a sentence').toBe('Cíl dosažen');
  expect(czech.say('office.log')).toBe('office.log');
  // The name of a file before an error does not prevent the translation of the sentence.
  const file = new Translator('cs', { '{0}, or {1}': '{0}, nebo {1}', 'the file is damaged, or not all is here: {0}': 'soubor je poškozený, nebo není celý: {0}' }, ['{0}, or {1}', 'the file is damaged, or not all is here: {0}']);
  expect(file.say('a-b.gz: the file is damaged, or not all is here: checksum')).toBe('a-b.gz: soubor je poškozený, nebo není celý: checksum');
  const polish = new Translator('pl', { '{0} scans': { by: 0, one: '{0} skan', few: '{0} skany', many: '{0} skanów', other: '{0} skanu' } }, []);
  expect([1, 2, 5, 12, 22, '0,5'].map((count) => polish.compose(['', ' scans'], [count]))).toEqual(['1 skan', '2 skany', '5 skanów', '12 skanów', '22 skany', '0,5 skanu']);
});
