// Particles as discs (2D) or as impostors of spheres (3D); arrows with a width in pixels.

export const particleVertex = /* glsl */ `
in float radius;
in float value;
uniform float size;       // factor of the radii
uniform float height;     // of the picture, pixels
uniform bool sphere;
uniform vec4 clip;        // what lies beyond the plane is cut off: normal, distance
out float vValue;
out float vRadius;
out float vDepth;
out float vPixels;
void main() {
  vec4 centre = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * centre;
  vRadius = radius * size;
  vValue = value;
  vDepth = centre.z;
  vPixels = 2.0 * vRadius * projectionMatrix[1][1] * 0.5 * height / gl_Position.w;
  // Small discs are drawn larger, so that a body has no gaps; large ones at their own size.
  if (!sphere) vPixels *= mix(1.3, 1.0, smoothstep(24.0, 60.0, vPixels));
  gl_PointSize = max(vPixels, 1.5);
  if (dot(clip.xyz, position) > clip.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

export const particleFragment = /* glsl */ `
precision highp float;
uniform mat4 projectionMatrix;
uniform sampler2D colours;
uniform vec2 range;
uniform bool logarithmic;
uniform bool plain;       // one colour for all
uniform vec3 colour;
uniform vec3 noValue;
uniform float opacity;
uniform bool sphere;
uniform bool ring;        // the mark around a picked particle
in float vValue;
in float vRadius;
in float vDepth;
in float vPixels;
out vec4 result;

vec3 mapped() {
  if (plain) return colour;
  if (vValue < -1e37) return noValue;
  vec2 ends = logarithmic ? log(range) : range;
  float v = logarithmic ? log(max(vValue, range.x)) : vValue;
  float x = clamp((v - ends.x) / (ends.y - ends.x), 0.0, 1.0);
  return texture(colours, vec2((x * 255.0 + 0.5) / 256.0, 0.5)).rgb;
}

void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  float r2 = dot(at, at);
  if (r2 > 1.0) discard;
  float edge = vPixels > 12.0 ? 1.0 - smoothstep(1.0 - 3.0 / vPixels, 1.0, sqrt(r2)) : 1.0;
  gl_FragDepth = gl_FragCoord.z;
  if (ring) {
    if (r2 < 0.5) discard;
    result = vec4(colour, edge);
    return;
  }
  vec3 tone = mapped();
  if (sphere) {
    float z = sqrt(1.0 - r2);
    vec3 normal = vec3(at.x, -at.y, z);
    float light = 0.45 + 0.6 * max(dot(normal, vec3(-0.3980, 0.5970, 0.6965)), 0.0);
    // Depth of the sphere's surface at this pixel; spheres have a perspective camera, whose w is -z.
    float front = vDepth + z * vRadius;
    gl_FragDepth = 0.5 - 0.5 * (projectionMatrix[2][2] * front + projectionMatrix[3][2]) / front;
    result = vec4(min(tone * light, 1.0), 1.0);
    return;
  }
  // Particles get a dark rim once they are large enough.
  float rim = vPixels > 16.0 ? mix(1.0, 0.8, smoothstep(0.7, 1.0, r2)) : 1.0;
  result = vec4(tone * rim, opacity * edge);
}`;

/// An arrow lies along x from 0 to 1, its width in y. Both its ends are projected, so that it lies in the plane of the picture.
export const arrowVertex = /* glsl */ `
in vec3 start;
in vec3 vector;
uniform float scale;
uniform vec2 viewport;
uniform float width;      // of the shaft, pixels
uniform float rim;        // pixels wider all around
uniform vec4 clip;
void main() {
  vec4 a = projectionMatrix * modelViewMatrix * vec4(start, 1.0);
  vec4 b = projectionMatrix * modelViewMatrix * vec4(start + scale * vector, 1.0);
  vec2 from = a.xy / a.w * 0.5 * viewport;
  vec2 to = b.xy / b.w * 0.5 * viewport;
  vec2 along = to - from;
  float length_ = max(length(along), 1e-6);
  vec2 unit = along / length_;
  vec2 across = vec2(-unit.y, unit.x);
  float head = min(5.0 * width, 0.6 * length_);
  float x = position.z > 0.5 ? length_ - head * (1.0 - position.x) + rim * (3.0 * position.x - 1.0) : (length_ - head) * position.x - rim;
  float half_ = position.z > 0.5 ? 0.5 * head + 1.6 * rim : 0.5 * width + rim;
  vec2 place = from + unit * x + across * (position.y * half_);
  gl_Position = vec4(place / (0.5 * viewport) * a.w, min(a.z, b.z) - 1e-4 * a.w, a.w);
  if (length_ < 1.0 || dot(clip.xyz, start) > clip.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

export const arrowFragment = /* glsl */ `
precision highp float;
uniform vec3 colour;
out vec4 result;
void main() { result = vec4(colour, 1.0); }`;
