// Shaders: vertex, fragment. Light comes from above the viewer's left shoulder.

const LIGHT = `
float lit(vec3 normal) { return 0.62 + 0.42 * max(0.0, dot(normal, normalize(vec3(-0.4, 0.7, 0.6)))); }`;

/** Balls, drawn as squares that face the viewer; with the extension their depth is that of a ball too. */
const BALL = depth => [`
attribute vec3 position, colour;
uniform mat4 view, projection;
uniform float radius, pixels;
varying vec3 tint, middle;
void main() {
  vec4 eye = view * vec4(position, 1.0);
  gl_Position = projection * eye;
  gl_PointSize = max(1.0, pixels * radius / -eye.z);
  tint = colour;
  middle = eye.xyz;
}`, `${depth ? "#extension GL_EXT_frag_depth : enable" : ""}
precision highp float;
uniform mat4 projection;
uniform float radius;
varying vec3 tint, middle;
${LIGHT}
void main() {
  vec2 at = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float inside = 1.0 - dot(at, at);
  if (inside < 0.0) discard;
  vec3 normal = vec3(at, sqrt(inside));
  ${depth ? `vec4 clip = projection * vec4(middle + radius * normal, 1.0);
  gl_FragDepthEXT = 0.5 + 0.5 * clip.z / clip.w;` : ""}
  gl_FragColor = vec4(tint * lit(normal) * (0.8 + 0.2 * normal.z), 1.0);
}`];

/** Triangles of a rigid part. */
const SOLID = [`
attribute vec3 position, normal;
uniform mat4 view, projection, pose;
varying vec3 facing;
void main() {
  gl_Position = projection * view * pose * vec4(position, 1.0);
  facing = (view * pose * vec4(normal, 0.0)).xyz;
}`, `
precision highp float;
uniform vec4 colour;
varying vec3 facing;
${LIGHT}
void main() {
  vec3 normal = normalize(facing);
  gl_FragColor = vec4(colour.rgb * lit(gl_FrontFacing ? normal : -normal), colour.a);
}`];

/** Thin lines of one colour. */
const LINE = [`
attribute vec3 position;
uniform mat4 view, projection;
void main() { gl_Position = projection * view * vec4(position, 1.0); }`, `
precision highp float;
uniform vec4 colour;
void main() { gl_FragColor = colour; }`];

/** Ribbons that face the viewer: `corner` is how far along and on which side, half as wide there as `width` pixels. */
const RIBBON = [`
attribute vec3 position, other;
attribute vec2 corner;
uniform mat4 view, projection;
uniform vec2 screen;
void main() {
  mat4 both = projection * view;
  vec4 a = both * vec4(position, 1.0), b = both * vec4(other, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * screen;
  vec2 unit = length(along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  gl_Position = a;
  gl_Position.xy += corner.x * corner.y * vec2(-unit.y, unit.x) / screen * a.w;
}`, LINE[1]];
