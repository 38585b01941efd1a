// As the tests, for what is measured only when it is asked for.
import config from './playwright.config.ts';

export default { ...config, testMatch: '*.measure.ts', reporter: 'line', retries: 0, projects: config.projects?.filter(({ name }) => name === 'desktop') };
