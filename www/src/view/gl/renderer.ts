// Draws lists with WebGL2. Data that stay the same from picture to picture stay on the graphics
// card: rows of shapes until a sheet is recorded again, bulk for as long as it is drawn, and the
// tiles of a grid, of which only changed blocks are sent.

import type { Camera } from "../camera.js";
import type { Tile, Tiles } from "../tiles.js";
import { Atlas } from "./atlas.js";
import { Dashes } from "./dashes.js";
import { List, type Order, ROW_BYTES } from "./list.js";
import { IDENTITY, inverse, type Matrix, scaleOf, times } from "./matrix.js";
import { GlPencil } from "./pencil.js";
import { type Program, programsOf } from "./programs.js";

/** Most blocks sent for one picture: a whole map arrives within a moment. */
const MOST_BLOCKS = 400;
/** Tiles that were not drawn for this many pictures are freed. */
const KEPT_PICTURES = 600;

/** A sheet, and the view that it was recorded for. */
export interface Recorded {
  readonly list: List;
  matrix: Matrix | null;
}

interface Rows { readonly buffer: WebGLBuffer; readonly vao: WebGLVertexArrayObject; version: number; bytes: number }
interface Crowd { readonly buffer: WebGLBuffer; readonly vao: WebGLVertexArrayObject; usedAt: number }
interface Texture { readonly texture: WebGLTexture; upTo: number; hasLevels: boolean; usedAt: number }

export class GlRenderer {
  readonly atlas: Atlas;
  readonly dashes: Dashes;
  readonly #programs: ReturnType<typeof programsOf>;
  readonly #rows = new Map<List, Rows>();
  readonly #crowds = new Map<Float32Array, Crowd>();
  readonly #textures = new Map<Tile, Texture>();
  readonly #texts: WebGLTexture;
  readonly #empty: WebGLVertexArrayObject;
  #textsVersion = -1;
  #picture = 0;
  /** Blocks that may still be sent for this picture. */
  #budget = 0;
  /** Whether more of a grid has to be sent than one picture has time for. */
  isBehind = false;

  constructor(readonly gl: WebGL2RenderingContext) {
    this.atlas = new Atlas();
    this.dashes = new Dashes();
    this.#programs = programsOf(gl);
    this.#texts = gl.createTexture();
    this.#empty = gl.createVertexArray();
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.bindTexture(gl.TEXTURE_2D, this.#texts);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  /** Why it cannot draw; null if it can. */
  get fault(): string | null {
    const { shapes, squares, tiles } = this.#programs;
    return shapes.fault ?? squares.fault ?? tiles.fault;
  }

  /** Changes when texts or dashes were dropped: sheets have to be recorded again. */
  get generation(): number {
    return this.atlas.generation + this.dashes.generation;
  }

  /** Begins to record a sheet. */
  record(sheet: Recorded, camera: Camera): GlPencil {
    sheet.list.clear();
    sheet.matrix = camera.transform;
    return new GlPencil(sheet.list, camera, this.atlas, this.dashes);
  }

  /** Draws the sheets, the lowest first, each at its place in this view. */
  draw(sheets: readonly Recorded[], camera: Camera): void {
    const { gl } = this;
    this.#picture += 1;
    [this.#budget, this.isBehind] = [MOST_BLOCKS, false];
    const { width, height } = gl.canvas;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.depthFunc(gl.LESS);
    this.#sendTexts();
    for (const { list, matrix } of sheets) {
      if (!matrix || list.orders.length === 0) continue;
      const there = camera.transform;
      const moved = matrix.every((value, i) => value === there[i]) ? IDENTITY : times(there, inverse(matrix));
      gl.clear(gl.DEPTH_BUFFER_BIT);
      this.#sendRows(list);
      for (const order of list.orders) this.#obey(order, list, moved);
    }
    gl.bindVertexArray(null);
    this.#sweep();
  }

  #obey(order: Order, list: List, moved: Matrix): void {
    const { gl } = this;
    switch (order.what) {
      case "shapes":
        this.#shapes(list, moved);
        return this.#drawRows(list, order.from, order.to);
      case "fill":
        return this.#fill(order, list, moved);
      case "tiles":
        return this.#tiles(order.tiles, times(moved, order.matrix), order.alpha);
      case "squares": {
        const { squares } = this.#programs;
        this.#use(squares, times(moved, order.matrix));
        gl.uniform4f(squares.at("ink"), ...partsOf(order.colour));
        gl.uniform1f(squares.at("side"), order.side);
        gl.uniform1f(squares.at("stroke"), order.stroke);
        gl.enable(gl.DEPTH_TEST);
        gl.bindVertexArray(this.#crowdOf(order.points, 2).vao);
        return gl.drawArrays(gl.POINTS, 0, order.points.length >> 1);
      }
      case "segments":
        this.#shapes(list, times(moved, order.matrix));
        gl.bindVertexArray(this.#crowdOf(order.ends, 4).vao);
        gl.vertexAttrib4f(1, order.halfWidth, 0, order.dash, 0);
        gl.vertexAttrib2f(2, 0, order.stroke);
        gl.vertexAttrib4f(3, ...partsOf(order.colour));
        return gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, order.ends.length >> 2);
    }
  }

  #use(program: Program, [a, b, c, d, e, f]: Matrix): void {
    const { gl } = this;
    gl.useProgram(program.program);
    gl.uniform4f(program.at("linear"), a, b, c, d);
    gl.uniform2f(program.at("shift"), e, f);
    gl.uniform2f(program.at("size"), gl.canvas.width, gl.canvas.height);
  }

  #shapes(list: List, matrix: Matrix): void {
    const { gl, dashes } = this;
    const { shapes } = this.#programs;
    this.#use(shapes, matrix);
    gl.uniform4fv(shapes.at("dashes"), dashes.table);
    gl.bindTexture(gl.TEXTURE_2D, this.#texts);
    gl.bindVertexArray(this.#rowsOf(list).vao);
    gl.enable(gl.DEPTH_TEST);
  }

  #drawRows(list: List, from: number, to: number): void {
    const { gl } = this;
    // WebGL2 has no first instance, so the attributes begin at an offset.
    gl.bindBuffer(gl.ARRAY_BUFFER, this.#rowsOf(list).buffer);
    const begin = from * ROW_BYTES;
    gl.vertexAttribPointer(0, 4, gl.FLOAT, false, ROW_BYTES, begin);
    gl.vertexAttribPointer(1, 4, gl.FLOAT, false, ROW_BYTES, begin + 16);
    gl.vertexAttribPointer(2, 2, gl.FLOAT, false, ROW_BYTES, begin + 32);
    gl.vertexAttribPointer(3, 4, gl.UNSIGNED_BYTE, true, ROW_BYTES, begin + 40);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, to - from);
  }

  #fill({ from, to, rule }: Extract<Order, { what: "fill" }>, list: List, moved: Matrix): void {
    const { gl } = this;
    this.#shapes(list, moved);
    gl.enable(gl.STENCIL_TEST);
    gl.colorMask(false, false, false, false);
    gl.disable(gl.DEPTH_TEST);
    gl.stencilFunc(gl.ALWAYS, 0, 0xff);
    if (rule === "evenodd") gl.stencilOp(gl.KEEP, gl.KEEP, gl.INVERT);
    else {
      gl.stencilOpSeparate(gl.FRONT, gl.KEEP, gl.KEEP, gl.INCR_WRAP);
      gl.stencilOpSeparate(gl.BACK, gl.KEEP, gl.KEEP, gl.DECR_WRAP);
    }
    this.#drawRows(list, from, to - 1);
    gl.colorMask(true, true, true, true);
    gl.enable(gl.DEPTH_TEST);
    gl.stencilFunc(gl.NOTEQUAL, 0, 0xff);
    gl.stencilOp(gl.ZERO, gl.ZERO, gl.ZERO);
    this.#drawRows(list, to - 1, to);
    gl.disable(gl.STENCIL_TEST);
  }

  // --- What the graphics card keeps -------------------------------------------------------------

  #rowsOf(list: List): Rows {
    const { gl } = this;
    let rows = this.#rows.get(list);
    if (!rows) {
      rows = { buffer: gl.createBuffer(), vao: gl.createVertexArray(), version: -1, bytes: 0 };
      this.#rows.set(list, rows);
      gl.bindVertexArray(rows.vao);
      for (let i = 0; i < 4; i += 1) {
        gl.enableVertexAttribArray(i);
        gl.vertexAttribDivisor(i, 1);
      }
    }
    return rows;
  }

  #sendRows(list: List): void {
    const { gl } = this;
    const rows = this.#rowsOf(list);
    if (rows.version === list.version) return;
    rows.version = list.version;
    gl.bindBuffer(gl.ARRAY_BUFFER, rows.buffer);
    const data = list.rows;
    if (data.byteLength > rows.bytes) gl.bufferData(gl.ARRAY_BUFFER, (rows.bytes = 2 * data.byteLength), gl.DYNAMIC_DRAW);
    if (data.length > 0) gl.bufferSubData(gl.ARRAY_BUFFER, 0, data);
  }

  #crowdOf(data: Float32Array, words: 2 | 4): Crowd {
    const { gl } = this;
    let crowd = this.#crowds.get(data);
    if (!crowd) {
      crowd = { buffer: gl.createBuffer(), vao: gl.createVertexArray(), usedAt: 0 };
      this.#crowds.set(data, crowd);
      gl.bindVertexArray(crowd.vao);
      gl.bindBuffer(gl.ARRAY_BUFFER, crowd.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, words, gl.FLOAT, false, 0, 0);
      if (words === 4) gl.vertexAttribDivisor(0, 1);
    }
    crowd.usedAt = this.#picture;
    return crowd;
  }

  #sendTexts(): void {
    const { gl, atlas } = this;
    if (this.#textsVersion === atlas.version) return;
    this.#textsVersion = atlas.version;
    gl.bindTexture(gl.TEXTURE_2D, this.#texts);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, atlas.canvas);
  }

  #tiles(tiles: Tiles, matrix: Matrix, alpha: number): void {
    const { gl } = this;
    const { tiles: program } = this.#programs;
    this.#use(program, matrix);
    gl.uniform1f(program.at("alpha"), alpha);
    // Upright tiles meet on whole pixels, as on a canvas.
    gl.uniform1f(program.at("whole"), matrix[1] === 0 && matrix[2] === 0 ? 1 : 0);
    gl.bindVertexArray(this.#empty);
    gl.disable(gl.DEPTH_TEST);
    const side = tiles.tileCells * tiles.resolution;
    const isSmall = scaleOf(matrix) * tiles.resolution < 1;
    const { width, height } = gl.canvas;
    const [a, b, c, d, e, f] = matrix;
    for (const tile of tiles.all()) {
      const [x, y] = [tile.col * side, tile.row * side];
      // The position of its middle, and a bound on the distance of its corners from it.
      const [midX, midY, reach] = [a * (x + side / 2) + c * (y + side / 2) + e, b * (x + side / 2) + d * (y + side / 2) + f, side * scaleOf(matrix)];
      if (midX < -reach || midY < -reach || midX > width + reach || midY > height + reach) continue;
      this.#bindTile(tiles, tile, isSmall);
      gl.uniform4f(program.at("box"), x, y, (tile.col + 1) * side, (tile.row + 1) * side);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
  }

  /** Sends the changes of a tile, and makes its mipmaps only if they are needed. */
  #bindTile(tiles: Tiles, tile: Tile, isSmall: boolean): void {
    const { gl } = this;
    const cells = tiles.tileCells;
    let kept = this.#textures.get(tile);
    if (!kept) {
      kept = { texture: gl.createTexture(), upTo: 0, hasLevels: false, usedAt: 0 };
      this.#textures.set(tile, kept);
      gl.bindTexture(gl.TEXTURE_2D, kept.texture);
      gl.texStorage2D(gl.TEXTURE_2D, Math.floor(Math.log2(cells)) + 1, gl.RGBA8, cells, cells);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    }
    kept.usedAt = this.#picture;
    gl.bindTexture(gl.TEXTURE_2D, kept.texture);
    if (kept.upTo < tiles.version) {
      const since = kept.upTo;
      const changed = [...tile.blocks.values()].filter(({ version }) => version > since);
      if (changed.length > this.#budget) this.isBehind = true;
      else {
        this.#budget -= changed.length;
        for (const block of changed) {
          const pixels = tiles.pixelsOf(block);
          gl.texSubImage2D(gl.TEXTURE_2D, 0, ...tiles.placeOf(block), pixels.width, pixels.height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.data.buffer));
        }
        kept.upTo = tiles.version;
        if (changed.length > 0) kept.hasLevels = false;
      }
    }
    if (isSmall && !kept.hasLevels) {
      gl.generateMipmap(gl.TEXTURE_2D);
      kept.hasLevels = true;
    }
  }

  #sweep(): void {
    const { gl } = this;
    for (const [data, crowd] of this.#crowds) {
      if (crowd.usedAt === this.#picture) continue;
      gl.deleteBuffer(crowd.buffer);
      gl.deleteVertexArray(crowd.vao);
      this.#crowds.delete(data);
    }
    for (const [tile, { texture, usedAt }] of this.#textures) {
      if (this.#picture - usedAt < KEPT_PICTURES) continue;
      gl.deleteTexture(texture);
      this.#textures.delete(tile);
    }
  }
}

/** Red, green, blue and alpha, 0 to 1. */
function partsOf(word: number): [number, number, number, number] {
  return [(word & 255) / 255, ((word >>> 8) & 255) / 255, ((word >>> 16) & 255) / 255, (word >>> 24) / 255];
}
