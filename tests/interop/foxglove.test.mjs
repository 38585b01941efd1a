// The read-only endpoint, with Foxglove's own client and its own reader of ROS 2 messages.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { after, before, test } from 'node:test';
import rosmsg from '@foxglove/rosmsg';
import serialization from '@foxglove/rosmsg2-serialization';
import protocol from '@foxglove/ws-protocol';
import { WebSocket } from 'ws';
import { startBridge } from './bridge.mjs';

const { parse } = rosmsg;
const { MessageReader } = serialization;
const { FoxgloveClient } = protocol;

let bridge;
before(async () => (bridge = await startBridge(['--foxglove'])));
after(() => bridge.stop());

const address = () => `ws://127.0.0.1:${bridge.port}/foxglove`;

for (const name of ['foxglove.websocket.v1', 'foxglove.sdk.v1']) {
  test(`${name}: every channel is advertised, and its messages read as their schema says`, { timeout: 60_000 }, async () => {
    const socket = new WebSocket(address(), [name]);
    const client = new FoxgloveClient({ ws: socket });
    const info = new Promise((resolve) => client.on('serverInfo', resolve));
    const channels = await new Promise((resolve) => client.on('advertise', resolve));
    assert.match((await info).name, /^slamlab/);
    assert.deepEqual((await info).capabilities, []);
    assert.equal(socket.protocol, name);
    assert.deepEqual(channels.map((channel) => channel.topic), ['/scan', '/points', '/odom', '/tf']);
    const readers = new Map();
    for (const channel of channels) {
      const reader = new MessageReader(parse(channel.schema, { ros2: true }));
      readers.set(client.subscribe(channel.id), { topic: channel.topic, reader });
    }
    const seen = new Map();
    await new Promise((resolve) => {
      client.on('message', ({ subscriptionId, timestamp, data }) => {
        const { topic, reader } = readers.get(subscriptionId);
        seen.set(topic, { timestamp, message: reader.readMessage(data) });
        if (seen.size === channels.length) resolve();
      });
    });
    const { message: scan, timestamp } = seen.get('/scan');
    assert.equal(scan.header.frame_id, 'laser');
    assert.equal(BigInt(scan.header.stamp.sec) * 1_000_000_000n + BigInt(scan.header.stamp.nanosec), timestamp);
    const returns = scan.ranges.filter(Number.isFinite).length;
    assert.ok(returns > 100, `${returns} returns`);
    assert.equal(seen.get('/odom').message.child_frame_id, 'base_link');
    assert.equal(seen.get('/points').message.point_step, 12);
    client.close();
  });
}

test('whatever is more than watching is refused in words', { timeout: 60_000 }, async () => {
  const socket = new WebSocket(address(), ['foxglove.websocket.v1']);
  const client = new FoxgloveClient({ ws: socket });
  await new Promise((resolve) => client.on('advertise', resolve));
  const status = new Promise((resolve) => client.on('status', resolve));
  client.advertise({ topic: '/cmd_vel', encoding: 'json', schemaName: 'geometry_msgs/msg/Twist' });
  assert.match((await status).message, /takes nothing/);
  client.close();
});

test('the gates are those of the bridge', { timeout: 60_000 }, async () => {
  const refused = async (protocols, options) => {
    const socket = new WebSocket(address(), protocols, options);
    const [, response] = await once(socket, 'unexpected-response');
    socket.on('error', () => {});
    socket.terminate();
    return response.statusCode;
  };
  const name = ['foxglove.websocket.v1'];
  assert.equal(await refused(name, { origin: 'https://evil.example' }), 403);
  assert.equal(await refused(name, { headers: { Host: 'evil.example' } }), 421);
  assert.equal(await refused(['chat'], {}), 400);
  const [private_, plain] = await Promise.all([startBridge(['--private']), startBridge([])]);
  for (const { port } of [private_, plain]) {
    const answer = await fetch(`http://127.0.0.1:${port}/foxglove`);
    assert.equal(answer.status, 404, 'it is off unless it is asked for');
  }
  await Promise.all([private_.stop(), plain.stop()]);
});
