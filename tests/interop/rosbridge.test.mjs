// The rosbridge subset, with roslib as the independent client.
import assert from 'node:assert/strict';
import { createHmac } from 'node:crypto';
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

async function enter(ros, token) {
  const { challenge } = await call(ros, '/slamlab/challenge');
  const mac = createHmac('sha256', token).update('slamlab bridge 1').update(Buffer.from(challenge, 'hex'));
  return call(ros, '/slamlab/enter', { proof: mac.digest('hex') });
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

test('nobody drives without the token, and a wrong or replayed proof ends the connection', { timeout: 60_000 }, async () => {
  const closed = async (act) => {
    const socket = new WebSocket(address());
    await once(socket, 'open');
    await act(socket);
    const [code] = await once(socket, 'close');
    return code;
  };
  const say = (socket, message) => socket.send(JSON.stringify(message));
  const msg = { linear: { x: 0.1 }, angular: { z: 0 } };
  assert.equal(await closed((socket) => say(socket, { op: 'publish', topic: '/cmd_vel', msg })), 4003);
  assert.equal(await closed((socket) => say(socket, { op: 'call_service', service: '/slamlab/take' })), 4003);
  const wrong = { op: 'call_service', service: '/slamlab/enter', args: { proof: '00'.repeat(32) } };
  assert.equal(await closed((socket) => say(socket, wrong)), 4001);
  const replayed = async (socket) => {
    say(socket, { op: 'call_service', service: '/slamlab/challenge' });
    const [data] = await once(socket, 'message');
    const { challenge } = JSON.parse(data).values;
    const mac = createHmac('sha256', bridge.token).update('slamlab bridge 1').update(Buffer.from(challenge, 'hex')).digest('hex');
    const proof = { op: 'call_service', service: '/slamlab/enter', args: { proof: mac } };
    say(socket, proof);
    say(socket, proof);
  };
  assert.equal(await closed(replayed), 4001);
  assert.equal(await closed((socket) => socket.send('{')), 1007);
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
  const mac = createHmac('sha256', bridge.token).update('slamlab bridge 1').update(Buffer.from(values.challenge, 'hex'));
  await ask('/slamlab/enter', { proof: mac.digest('hex') });
  await ask('/slamlab/take', { force: true });
  assert.equal((await ask('/slamlab/arm')).result, true);
  say({ op: 'publish', topic: '/cmd_vel', msg: { linear: { x: 0.1 }, angular: { z: 0 } } });
  const refusal = await until((message) => message.op === 'status');
  assert.match(refusal.msg, /TooOld/);
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
