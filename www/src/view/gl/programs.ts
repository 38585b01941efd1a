// The three programs of the graphics card. Positions are device pixels, y down.
//
// 1. Shapes: each row is drawn as a rectangle that contains its shape; the coverage of a pixel
//    follows from its distance to the edge. A line that crosses a pixel twice must not be drawn
//    twice: each stroke has a depth of its own, and only a larger coverage comes in front.
// 2. Squares: points of whole pixels.
// 3. Tiles: images of cells.

import { KIND, MOST_STROKES } from "./list.js";
import { LENGTHS, MOST } from "./dashes.js";

const HEAD = `#version 300 es
precision highp float;
uniform vec4 linear;
uniform vec2 shift;
uniform vec2 size;
vec2 moved(vec2 p) { return linear.xy * p.x + linear.zw * p.y + shift; }
vec4 placed(vec2 p) { return vec4(p.x / size.x * 2.0 - 1.0, 1.0 - p.y / size.y * 2.0, 0.0, 1.0); }
float depthOf(float stroke, float part) { return (${MOST_STROKES + 2}.0 - stroke - 0.9 * part) / ${MOST_STROKES + 2}.0; }
`;

const FRAGMENT_HEAD = `#version 300 es
precision highp float;
out vec4 result;
`;

const SHAPES_VERTEX = `${HEAD}
layout(location = 0) in vec4 a;
layout(location = 1) in vec4 b;
layout(location = 2) in vec2 kindAndStroke;
layout(location = 3) in vec4 colour;
flat out vec4 first;
flat out vec4 second;
flat out vec2 which;
flat out vec4 ink;
out vec2 at;
void main() {
  vec2 side = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 corner = side * 2.0 - 1.0;
  which = kindAndStroke;
  ink = vec4(colour.rgb * colour.a, colour.a);
  first = a;
  second = b;
  int kind = int(which.x);
  vec2 p;
  if (kind == ${KIND.segment}) {
    vec2 begin = moved(a.xy);
    vec2 way = moved(a.zw) - begin;
    float length_ = length(way);
    vec2 along = length_ > 0.0 ? way / length_ : vec2(1.0, 0.0);
    float pad = b.x + 1.0;
    at = vec2(mix(-pad, length_ + pad, side.x), pad * corner.y);
    p = begin + along * at.x + vec2(-along.y, along.x) * at.y;
    first.x = length_;
    second.y = b.y * length(linear.xy);
  } else if (kind == ${KIND.ellipse}) {
    vec2 u = linear.xy * a.z + linear.zw * a.w;
    vec2 v = linear.xy * b.x + linear.zw * b.y;
    at = (sqrt(u * u + v * v) + max(b.z, 0.0) + 1.0) * corner;
    p = moved(a.xy) + at;
    first = vec4(u, v);
  } else if (kind == ${KIND.triangle}) {
    p = moved(gl_VertexID == 0 ? a.xy : gl_VertexID == 1 ? a.zw : b.xy);
    at = p;
  } else {
    p = moved(a.xy) + a.zw * side;
    at = b.xy + b.zw * side;
  }
  gl_Position = placed(p);
}
`;

const SHAPES_FRAGMENT = `${FRAGMENT_HEAD}
uniform vec4 dashes[${2 * MOST}];
uniform sampler2D texts;
flat in vec4 first;
flat in vec4 second;
flat in vec2 which;
flat in vec4 ink;
in vec2 at;
float depthOf(float stroke, float part) { return (${MOST_STROKES + 2}.0 - stroke - 0.9 * part) / ${MOST_STROKES + 2}.0; }

/** How far a place on the line is from the nearest dash, negative in it. */
float offDash(int pattern, float s) {
  vec4 p = dashes[2 * pattern];
  vec4 q = dashes[2 * pattern + 1];
  float[${LENGTHS}] lengths = float[](p.x, p.y, p.z, p.w, q.x, q.y);
  float whole = q.z;
  float m = mod(s, whole);
  float off = 1e9;
  float begin = 0.0;
  for (int i = 0; i < ${LENGTHS}; i += 2) {
    float end = begin + lengths[i];
    if (i == 0 || lengths[i] > 0.0) {
      off = min(off, max(begin - m, m - end));
      off = min(off, max(begin - m - whole, m + whole - end));
      off = min(off, max(begin - m + whole, m - whole - end));
    }
    begin = end + lengths[i + 1];
  }
  return off;
}

/** How much of a pixel a line covers whose middle is so far away. */
float covered(float off, float halfWidth) {
  return min(1.0, 2.0 * halfWidth) * clamp(max(halfWidth, 0.5) - off + 0.5, 0.0, 1.0);
}

void main() {
  int kind = int(which.x);
  float part = 1.0;
  if (kind == ${KIND.segment}) {
    float beyond = max(-at.x, at.x - first.x);
    int caps = int(second.w);
    int pattern = int(second.z);
    bool isRound = caps == 3 || (caps == 1 && at.x < 0.5 * first.x) || (caps == 2 && at.x >= 0.5 * first.x);
    if (pattern >= 0) {
      float off = offDash(pattern, at.x + second.y);
      part = isRound ? covered(length(vec2(max(off, 0.0), at.y)), second.x) : covered(abs(at.y), second.x) * clamp(0.5 - off, 0.0, 1.0);
      part *= clamp(0.5 - beyond + (isRound ? second.x : 0.0), 0.0, 1.0);
    } else if (isRound) part = covered(length(vec2(max(beyond, 0.0), at.y)), second.x);
    else part = covered(abs(at.y), second.x) * clamp(0.5 - beyond, 0.0, 1.0);
  } else if (kind == ${KIND.ellipse}) {
    vec2 u = first.xy;
    vec2 v = first.zw;
    float area = u.x * v.y - u.y * v.x;
    vec2 q = vec2(v.y * at.x - v.x * at.y, u.x * at.y - u.y * at.x) / area;
    float r = length(q);
    vec2 n = r > 1e-6 ? q / r : vec2(1.0, 0.0);
    // The distance to the edge, by the gradient of r.
    vec2 slope = vec2(v.y * n.x - u.y * n.y, u.x * n.y - v.x * n.x) / area;
    float off = (r - 1.0) / max(length(slope), 1e-9);
    if (second.z < 0.0) part = clamp(0.5 - off, 0.0, 1.0);
    else {
      part = covered(abs(off), second.z);
      if (second.w >= 0.0) {
        float turned = atan(q.y, q.x);
        if (turned < 0.0) turned += 6.2831853;
        part *= clamp(0.5 - offDash(int(second.w), turned * 0.5 * (length(u) + length(v))), 0.0, 1.0);
      }
    }
  } else if (kind == ${KIND.text}) part = texelFetch(texts, ivec2(at), 0).a;
  if (part < 0.004) discard;
  result = ink * part;
  gl_FragDepth = depthOf(which.y, part);
}
`;

const SQUARES_VERTEX = `${HEAD}
layout(location = 0) in vec2 point;
uniform float side;
uniform float stroke;
void main() {
  gl_Position = placed(floor(moved(point) - 0.5 * side + 0.5) + 0.5 * side);
  gl_Position.z = 2.0 * depthOf(stroke, 1.0) - 1.0;
  gl_PointSize = side;
}
`;

const SQUARES_FRAGMENT = `${FRAGMENT_HEAD}
uniform vec4 ink;
void main() { result = vec4(ink.rgb * ink.a, ink.a); }
`;

const TILES_VERTEX = `${HEAD}
uniform vec4 box;
uniform float whole;
out vec2 at;
void main() {
  vec2 side = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 p = moved(mix(box.xy, box.zw, side));
  gl_Position = placed(whole > 0.0 ? floor(p + 0.5) : p);
  at = vec2(side.x, 1.0 - side.y);
}
`;

const TILES_FRAGMENT = `${FRAGMENT_HEAD}
uniform sampler2D cells;
uniform float alpha;
in vec2 at;
void main() { result = texture(cells, at) * alpha; }
`;

/** A program, with the locations of its uniforms. */
export class Program {
  readonly program: WebGLProgram;
  #places = new Map<string, WebGLUniformLocation | null>();

  constructor(readonly gl: WebGL2RenderingContext, vertex: string, fragment: string) {
    this.program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
      const shader = gl.createShader(kind);
      if (!shader) continue;
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
  }

  /** Why it cannot be used; null if it can. */
  get fault(): string | null {
    const { gl, program } = this;
    if (gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    const logs = (gl.getAttachedShaders(program) ?? []).map((shader) => gl.getShaderInfoLog(shader) ?? "");
    return [gl.getProgramInfoLog(program) ?? "", ...logs].filter((log) => log !== "").join("; ");
  }

  at(name: string): WebGLUniformLocation | null {
    let place = this.#places.get(name);
    if (place === undefined) this.#places.set(name, (place = this.gl.getUniformLocation(this.program, name)));
    return place;
  }
}

export function programsOf(gl: WebGL2RenderingContext): { shapes: Program; squares: Program; tiles: Program } {
  return {
    shapes: new Program(gl, SHAPES_VERTEX, SHAPES_FRAGMENT),
    squares: new Program(gl, SQUARES_VERTEX, SQUARES_FRAGMENT),
    tiles: new Program(gl, TILES_VERTEX, TILES_FRAGMENT),
  };
}
