// Draws balls, rigid parts, lines and arrows with WebGL 1.

/** A renderer on `canvas`, or nothing where the browser offers no WebGL. */
function renderer(canvas) {
  const gl = canvas.getContext("webgl", { alpha: false, antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const programs = {
    ball: program(gl, BALL(Boolean(gl.getExtension("EXT_frag_depth")))),
    solid: program(gl, SOLID),
    line: program(gl, LINE),
    ribbon: program(gl, RIBBON),
  };
  let view, projection, pixels, screen;

  /** Makes `which` current with its attributes, arrays of `[numbers, columns]`, and what every program is told. */
  function use(which, attributes) {
    const { linked, places, buffers } = programs[which];
    gl.useProgram(linked);
    for (let i = 0; i < 4; i++) gl.disableVertexAttribArray(i);
    for (const [name, [numbers, columns]] of Object.entries(attributes)) {
      const place = places(name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name] ??= gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, columns, gl.FLOAT, false, 0, 0);
    }
    gl.uniformMatrix4fv(gl.getUniformLocation(linked, "view"), false, view);
    gl.uniformMatrix4fv(gl.getUniformLocation(linked, "projection"), false, projection);
    return name => gl.getUniformLocation(linked, name);
  }

  return {
    /** Clears the canvas at the size it now has and looks from the camera; `covered` pixels on the right lie under a panel. */
    begin(covered) {
      const ratio = window.devicePixelRatio || 1;
      const [width, height] = [canvas.clientWidth, canvas.clientHeight].map(n => Math.max(1, Math.round(n * ratio)));
      if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
      gl.viewport(0, 0, width, height);
      gl.clearColor(0.957, 0.961, 0.965, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      [view, projection] = [viewMatrix(), projectionMatrix(width / height, (covered * ratio) / width)];
      pixels = Math.min(width, height) * FOCUS;
      screen = [width / ratio, height / ratio];
    },

    /** Balls of one radius [m]; colours are rows of three like the positions. */
    balls(positions, colours, radius) {
      const uniform = use("ball", { position: [positions, 3], colour: [colours, 3] });
      gl.uniform1f(uniform("radius"), radius);
      gl.uniform1f(uniform("pixels"), pixels);
      gl.drawArrays(gl.POINTS, 0, positions.length / 3);
    },

    /** Triangles with one normal a corner, moved by `pose`, a matrix with columns first. */
    solid(corners, normals, pose, colour) {
      const uniform = use("solid", { position: [corners, 3], normal: [normals, 3] });
      gl.uniformMatrix4fv(uniform("pose"), false, pose);
      gl.uniform4fv(uniform("colour"), colour);
      gl.enable(gl.BLEND);
      gl.enable(gl.CULL_FACE);
      gl.depthMask(colour[3] > 0.99);
      // Far sides first, so that near ones are seen over them.
      for (const side of [gl.FRONT, gl.BACK]) {
        gl.cullFace(side);
        gl.drawArrays(gl.TRIANGLES, 0, corners.length / 3);
      }
      gl.depthMask(true);
      gl.disable(gl.CULL_FACE);
      gl.disable(gl.BLEND);
    },

    /** Segments, two rows each. */
    lines(ends, colour) {
      const uniform = use("line", { position: [new Float32Array(ends), 3] });
      gl.uniform4fv(uniform("colour"), colour);
      gl.enable(gl.BLEND);
      gl.drawArrays(gl.LINES, 0, ends.length / 3);
      gl.disable(gl.BLEND);
    },

    /** Arrows from each row of `from` by the same row of `by`, with a head. */
    arrows(from, by, scale, colour) {
      const at = [], towards = [], corner = [];
      // A triangle's corners as [fraction along the arrow, half width in pixels, side].
      const shape = [[0, 1.2, -1], [0, 1.2, 1], [0.7, 1.2, 1], [0, 1.2, -1], [0.7, 1.2, 1], [0.7, 1.2, -1], [0.7, 4, -1], [0.7, 4, 1], [1, 0, 1]];
      for (let i = 0; i < from.length; i += 3)
        for (const [fraction, half, side] of shape) {
          for (let k = 0; k < 3; k++) {
            at.push(from[i + k] + fraction * scale * by[i + k]);
            towards.push(from[i + k] + (fraction + 1) * scale * by[i + k]);
          }
          corner.push(2 * half, side);
        }
      const uniform = use("ribbon", {
        position: [new Float32Array(at), 3], other: [new Float32Array(towards), 3], corner: [new Float32Array(corner), 2],
      });
      gl.uniform4fv(uniform("colour"), colour);
      gl.uniform2fv(uniform("screen"), screen);
      gl.drawArrays(gl.TRIANGLES, 0, at.length / 3);
    },
  };
}

function program(gl, sources) {
  const linked = gl.createProgram();
  sources.forEach((source, i) => {
    const shader = gl.createShader(i ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
    gl.shaderSource(shader, source.trimStart());
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(linked, shader);
  });
  gl.linkProgram(linked);
  if (!gl.getProgramParameter(linked, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(linked));
  return { linked, places: name => gl.getAttribLocation(linked, name), buffers: {} };
}
