// The configuration of the tests, for measurements that run only on request.
import config from './playwright.config.ts';

export default { ...config, testMatch: '*.measure.ts', reporter: 'line', retries: 0, projects: config.projects?.filter(({ name }) => name === 'desktop') };
