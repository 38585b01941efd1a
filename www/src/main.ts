const worker = new Worker('worker.js', { type: 'module' });
worker.onmessage = (event: MessageEvent<string>) => {
  document.querySelector('#version')!.textContent = `slamlab ${event.data}`;
};
