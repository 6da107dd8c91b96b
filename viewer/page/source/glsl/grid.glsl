// A light grid: look_up.glsl stands behind these three functions.
uniform highp usampler2D words;  // four words a texel, 2048 texels a row
uniform uvec4 head[HEADER_COUNT];
uvec4 nlgFour(int i) { return texelFetch(words, ivec2(i & 2047, i >> 11), 0); }
uvec4 nlgHeader(int i) { return head[i]; }
uint nlgWord(int i) { return nlgFour(i >> 2)[i & 3]; }
