// Tells `cargo xtask test` which tests did not run and why: lines `WHAT` tab `WHY`
// (xtask/src/skips.rs).
import { appendFileSync } from 'node:fs';
import type { Reporter, TestCase, TestResult } from '@playwright/test/reporter';

export default class Skips implements Reporter {
  onTestEnd(test: TestCase, result: TestResult): void {
    const file = process.env.SLAMLAB_SKIPPED;
    if (!file || result.status !== 'skipped') return;
    const why = test.annotations.find(({ type }) => type === 'skip' || type === 'fixme')?.description ?? 'without a reason';
    const what = test.titlePath().filter((part) => part !== '').join(' › ');
    appendFileSync(file, `${what}\t${why.replaceAll(/\s+/g, ' ')}\n`);
  }
}
