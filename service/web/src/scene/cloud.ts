/** 100,000 points of a plane on the graphics card: one buffer, made once; panning and zooming change two numbers. */

const VERTEX = `#version 300 es
in vec2 place; in float kind; in float dim;
uniform vec4 view; uniform float size; uniform vec3 inks[9];
out vec4 ink;
void main() {
  gl_Position = vec4((place - view.xy) * view.zw, 0.0, 1.0);
  gl_PointSize = size;
  ink = vec4(inks[int(kind)], dim);
}`;
const FRAGMENT = `#version 300 es
precision mediump float;
in vec4 ink; out vec4 colour;
void main() {
  float away = length(gl_PointCoord - 0.5);
  if (away > 0.5) discard;
  colour = vec4(ink.rgb * ink.a, ink.a);
}`;

/** What is seen: the middle of the window, and pixels for one unit. */
export interface View {
  x: number;
  y: number;
  scale: number;
}

export class Cloud {
  private readonly gl: WebGL2RenderingContext;
  private readonly program: WebGLProgram;
  private readonly dims: WebGLBuffer;
  private readonly count: number;
  private pending = 0;
  private view: View = { x: 0, y: 0, scale: 1 };
  size = 3;

  /** places: (n, 2). kinds: (n,) 0 to 8, which ink. Error where there is no WebGL. */
  constructor(
    readonly canvas: HTMLCanvasElement,
    places: Float32Array,
    kinds: Uint8Array,
  ) {
    const gl = canvas.getContext("webgl2", { antialias: false, premultipliedAlpha: true, alpha: true });
    if (!gl) throw new Error("no WebGL");
    this.gl = gl;
    this.count = places.length / 2;
    this.program = this.linked();
    gl.useProgram(this.program);
    this.attribute("place", 2, gl.FLOAT, places, gl.STATIC_DRAW);
    this.attribute("kind", 1, gl.UNSIGNED_BYTE, kinds, gl.STATIC_DRAW);
    this.dims = this.attribute("dim", 1, gl.FLOAT, new Float32Array(this.count).fill(0.55), gl.DYNAMIC_DRAW);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  private linked(): WebGLProgram {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [
      [gl.VERTEX_SHADER, VERTEX],
      [gl.FRAGMENT_SHADER, FRAGMENT],
    ] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "no shader");
    return program;
  }

  private attribute(
    name: string,
    size: number,
    type: number,
    values: Float32Array | Uint8Array,
    usage: number,
  ): WebGLBuffer {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, usage);
    const at = gl.getAttribLocation(this.program, name);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, type, false, 0, 0);
    return buffer;
  }

  /** Nine colours as #RRGGBB, the last for what has none. */
  inks(colours: string[]): void {
    const values = colours.flatMap((one) => [1, 3, 5].map((at) => parseInt(one.slice(at, at + 2), 16) / 255));
    this.gl.useProgram(this.program);
    this.gl.uniform3fv(this.gl.getUniformLocation(this.program, "inks"), values);
    this.ask();
  }

  /** How strong each point is, 0 to 1: what is not looked at is dimmed. */
  dim(strengths: Float32Array): void {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.dims);
    this.gl.bufferSubData(this.gl.ARRAY_BUFFER, 0, strengths);
    this.ask();
  }

  look(view: View): void {
    this.view = view;
    this.ask();
  }

  resize(width: number, height: number): void {
    const ratio = Math.min(2, devicePixelRatio);
    this.canvas.width = Math.max(1, Math.round(width * ratio));
    this.canvas.height = Math.max(1, Math.round(height * ratio));
    this.ask();
  }

  private ask(): void {
    if (!this.pending) this.pending = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    this.pending = 0;
    const { gl, canvas, view } = this;
    const ratio = Math.min(2, devicePixelRatio);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.useProgram(this.program);
    const zoom = view.scale * ratio * 2;
    gl.uniform4f(
      gl.getUniformLocation(this.program, "view"),
      view.x,
      view.y,
      zoom / canvas.width,
      zoom / canvas.height,
    );
    gl.uniform1f(gl.getUniformLocation(this.program, "size"), this.size * ratio);
    gl.drawArrays(gl.POINTS, 0, this.count);
  }

  close(): void {
    cancelAnimationFrame(this.pending);
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}
