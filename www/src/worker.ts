import init, { version } from '../pkg/slamlab_web.js';

await init({ module_or_path: new URL('slamlab_web_bg.wasm', import.meta.url) });
self.postMessage(version());
