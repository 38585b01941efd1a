// The rosbridge subset, with roslib as the independent client.
import assert from 'node:assert/strict';
import { createHash, createHmac } from 'node:crypto';
import { once } from 'node:events';
import { after, before, test } from 'node:test';
import { Ros, Service, Topic } from 'roslib';
import { WebSocket } from 'ws';
import { startBridge } from './bridge.mjs';

let bridge;
before(async () => (bridge = await startBridge(['--rosbridge'])));
after(() => bridge.stop());

const address = () => `ws://127.0.0.1:${bridge.port}/rosbridge`;

async function connect() {
  const ros = new Ros({});
  const open = new Promise((resolve, reject) => {
    ros.on('connection', resolve);
    ros.on('error', reject);
  });
  ros.connect(address());
  await open;
  return ros;
}

const call = (ros, name, args = {}) =>
  new Promise((resolve, reject) => new Service({ ros, name, serviceType: '' }).callService(args, resolve, reject));

/** The first message of a topic that satisfies `is`. */
const first = (ros, name, messageType, is = () => true) =>
  new Promise((resolve) => {
    const topic = new Topic({ ros, name, messageType });
    topic.subscribe((message) => {
      if (!is(message)) return;
      topic.unsubscribe();
      resolve(message);
    });
  });

/** Shows that its sender has the token, as SCRAM does (RFC 5802 §3). */
function proofOf(token, challenge) {
  const hmac = (key, text) => createHmac('sha256', key).update(text).digest();
  const client = hmac(token, 'slamlab bridge 2');
  const stored = createHash('sha256').update(client).digest();
  const signature = hmac(stored, Buffer.from(challenge, 'hex'));
  return client.map((byte, at) => byte ^ signature[at]).toString('hex');
}

async function enter(ros, token) {
  const { challenge } = await call(ros, '/slamlab/challenge');
  return call(ros, '/slamlab/enter', { proof: proofOf(token, challenge) });
}

test('a watcher gets scans, odometry and transforms', { timeout: 60_000 }, async () => {
  const ros = await connect();
  const [scan, odom, tf] = await Promise.all([
    first(ros, '/scan', 'sensor_msgs/LaserScan'),
    first(ros, '/odom', 'nav_msgs/Odometry'),
    first(ros, '/tf', 'tf2_msgs/TFMessage'),
  ]);
  assert.equal(scan.header.frame_id, 'laser');
  const steps = (scan.angle_max - scan.angle_min) / scan.angle_increment;
  assert.ok(Math.abs(steps - (scan.ranges.length - 1)) < 0.01, `${steps} steps`);
  assert.ok(scan.ranges.filter((range) => range !== null).length > 100);
  assert.equal(odom.child_frame_id, 'base_link');
  assert.equal(odom.pose.covariance.length, 36);
  assert.ok(['odom', 'base_link'].includes(tf.transforms[0].header.frame_id));
  ros.close();
});

test('with proof, lease and arming it drives; the robot stops when it falls silent', { timeout: 60_000 }, async () => {
  const ros = await connect();
  await enter(ros, bridge.token);
  assert.ok((await call(ros, '/slamlab/take')).epoch > 0);
  assert.equal((await call(ros, '/slamlab/arm')).armed, true);
  const velocity = new Topic({ ros, name: '/cmd_vel', messageType: 'geometry_msgs/Twist' });
  const drive = setInterval(() => velocity.publish({ linear: { x: 0.08, y: 0, z: 0 }, angular: { x: 0, y: 0, z: 0 } }), 50);
  const moved = await first(ros, '/odom', 'nav_msgs/Odometry', (odom) => odom.pose.pose.position.x > 0.05);
  assert.ok(moved.twist.twist.linear.x > 0);
  clearInterval(drive);
  await first(ros, '/odom', 'nav_msgs/Odometry', (odom) => Math.abs(odom.twist.twist.linear.x) < 1e-3);
  ros.close();
});

/** A socket that keeps what it hears, and answers. */
async function raw(options = {}) {
  const socket = new WebSocket(address(), options);
  const heard = [];
  let closed = null;
  socket.on('message', (data) => heard.push(JSON.parse(data)));
  socket.on('close', (code) => (closed = code));
  await once(socket, 'open');
  const say = (message) => socket.send(typeof message === 'string' ? message : JSON.stringify(message));
  const until = async (is) => {
    for (;;) {
      const found = heard.find(is);
      if (found) return found;
      assert.equal(closed, null, 'it was closed');
      await Promise.race([once(socket, 'message'), once(socket, 'close')]);
    }
  };
  return { socket, say, until };
}

test('slips end no connection, and the stop after them is heard', { timeout: 60_000 }, async () => {
  const { socket, say, until } = await raw();
  const slips = [
    '{',
    '[]',
    { op: 'png', data: '' },
    { op: 'subscribe', topic: 'scan', throttle_rate: 100.0, id: 7 },
    { op: 'subscribe', topic: '/map', id: 8 },
    { op: 'publish', topic: '/cmd_vel', msg: { linear: 0.1 }, id: 9 },
    { op: 'publish', topic: '/cmd_vel', msg: { header: {}, twist: { linear: { x: 0.1 }, angular: { z: 0 } } }, id: 10 },
    { op: 'publish', topic: '/goal', msg: {}, id: 11 },
    { op: 'call_service', service: '/nothing', id: 12 },
    { op: 'call_service', service: '/slamlab/take', id: 13 },
    { op: 'call_service', service: '/slamlab/arm', id: 14 },
    { op: 'call_service', service: '/slamlab/release', args: [], id: 15 },
  ];
  for (const slip of slips) say(slip);
  say({ op: 'call_service', service: '/slamlab/stop', id: 16 });
  assert.equal((await until((message) => message.id === 16)).result, true);
  for (const id of [8, 9, 10, 11]) assert.equal((await until((message) => message.id === id)).op, 'status', String(id));
  for (const id of [12, 13, 14, 15]) assert.equal((await until((message) => message.id === id)).result, false, String(id));
  assert.equal((await until((message) => message.id === 13)).values.reason, 'no-right');
  await until((message) => message.op === 'publish' && message.topic === '/scan');
  say({ op: 'call_service', service: '/slamlab/emergency_stop', id: [1] });
  await until((message) => Array.isArray(message.id));
  socket.terminate();
});

test('whoever drives renews, stops, resets and releases by services, two calls at once', { timeout: 60_000 }, async () => {
  const ros = await connect();
  await enter(ros, bridge.token);
  await call(ros, '/slamlab/take', { force: true });
  await call(ros, '/slamlab/reset_emergency_stop');
  const [arm, renew] = await Promise.all([call(ros, '/slamlab/arm'), call(ros, '/slamlab/renew')]);
  assert.equal(arm.armed, true);
  assert.deepEqual(renew, {});
  const stamped = new Topic({ ros, name: '/cmd_vel', messageType: 'geometry_msgs/TwistStamped' });
  const drive = setInterval(() => stamped.publish({ header: {}, twist: { linear: { x: 0.08 }, angular: { z: 0 } } }), 50);
  await first(ros, '/odom', 'nav_msgs/Odometry', (odom) => odom.twist.twist.linear.x > 0.03);
  clearInterval(drive);
  await call(ros, '/slamlab/emergency_stop');
  await assert.rejects(call(ros, '/slamlab/arm'));
  await call(ros, '/slamlab/reset_emergency_stop');
  await call(ros, '/slamlab/release');
  await assert.rejects(call(ros, '/slamlab/renew'));
  ros.close();
});

test('rosapi says what there is', { timeout: 60_000 }, async () => {
  const ros = await connect();
  const ask = (method, ...args) => new Promise((resolve, reject) => ros[method](...args, resolve, reject));
  const topics = await ask('getTopics');
  assert.deepEqual(topics.topics, ['/cmd_vel', '/scan', '/odom', '/tf']);
  assert.equal(topics.types[1], 'sensor_msgs/msg/LaserScan');
  assert.equal(await ask('getTopicType', '/odom'), 'nav_msgs/msg/Odometry');
  assert.deepEqual(await ask('getTopicsForType', 'sensor_msgs/LaserScan'), ['/scan']);
  assert.ok((await ask('getServices')).includes('/slamlab/emergency_stop'));
  assert.deepEqual(await ask('getNodes'), ['/slamlab_bridge']);
  const params = await ask('getParams');
  assert.ok(params.includes('/slamlab/watchdog_ms'), String(params));
  const { value } = await call(ros, '/rosapi/get_param', { name: '/slamlab/watchdog_ms' });
  assert.equal(JSON.parse(value), 200);
  const { time } = await call(ros, '/rosapi/get_time');
  assert.ok(Math.abs(time.sec - Date.now() / 1000) < 60);
  await assert.rejects(call(ros, '/rosapi/get_param', { name: '/nothing' }));
  ros.close();
});

test('nobody drives without the token, a wrong proof ends the connection, and a replayed one is worth nothing', { timeout: 60_000 }, async () => {
  const closed = async (act) => {
    const socket = new WebSocket(address());
    await once(socket, 'open');
    await act(socket);
    const [code] = await once(socket, 'close');
    return code;
  };
  const say = (socket, message) => socket.send(JSON.stringify(message));
  const watcher = await raw();
  const msg = { linear: { x: 0.1 }, angular: { z: 0 } };
  watcher.say({ op: 'publish', topic: '/cmd_vel', msg });
  assert.match((await watcher.until((message) => message.op === 'status')).msg, /no-right/);
  watcher.socket.terminate();
  const enter = (proof) => ({ op: 'call_service', id: proof, service: '/slamlab/enter', args: { proof } });
  const challenged = async (socket) => {
    say(socket, { op: 'call_service', service: '/slamlab/challenge' });
    const [data] = await once(socket, 'message');
    return JSON.parse(data).values.challenge;
  };
  const wrong = async (socket) => {
    await challenged(socket);
    say(socket, enter('00'.repeat(32)));
  };
  assert.equal(await closed(wrong), 4001);
  const client = await raw();
  client.say({ op: 'call_service', id: 'challenge', service: '/slamlab/challenge' });
  const { values } = await client.until((message) => message.id === 'challenge');
  const proof = enter(proofOf(bridge.token, values.challenge));
  client.say(proof);
  client.say({ ...proof, id: 'again' });
  assert.equal((await client.until((message) => message.id === proof.id)).result, true);
  assert.equal((await client.until((message) => message.id === 'again')).result, false);
  client.socket.terminate();
});

/** A client that answers no ping cannot show that its commands are fresh. */
test('commands of a client that answers no ping are left out', { timeout: 60_000 }, async () => {
  const socket = new WebSocket(address(), { autoPong: false });
  const heard = [];
  socket.on('message', (data) => heard.push(JSON.parse(data)));
  await once(socket, 'open');
  const until = async (is) => {
    for (;;) {
      const found = heard.find(is);
      if (found) return found;
      await once(socket, 'message');
    }
  };
  const say = (message) => socket.send(JSON.stringify(message));
  const ask = (service, args = {}) => {
    say({ op: 'call_service', id: service, service, args });
    return until((message) => message.id === service);
  };
  const { values } = await ask('/slamlab/challenge');
  await ask('/slamlab/enter', { proof: proofOf(bridge.token, values.challenge) });
  await ask('/slamlab/take', { force: true });
  assert.equal((await ask('/slamlab/arm')).result, true);
  say({ op: 'publish', topic: '/cmd_vel', msg: { linear: { x: 0.1 }, angular: { z: 0 } } });
  const refusal = await until((message) => message.op === 'status');
  assert.match(refusal.msg, /too-old/);
  socket.terminate();
});

test('it is off unless it is asked for, and behind the same gates', { timeout: 60_000 }, async () => {
  const plain = await startBridge([]);
  const answer = await fetch(`http://127.0.0.1:${plain.port}/rosbridge`);
  assert.equal(answer.status, 404);
  await plain.stop();
  const socket = new WebSocket(address(), { origin: 'https://evil.example' });
  socket.on('error', () => {});
  const [, response] = await once(socket, 'unexpected-response');
  assert.equal(response.statusCode, 403);
});
