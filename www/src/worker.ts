import init, { version } from '../pkg/slamlab_web.js';

await init();
self.postMessage(version());
