// Texts of their own: a browser compiles only what it is asked to show.
#if defined(SHOWS_SHARE)
float shareOf(vec3 place, uint record) {
  NlgShares shares = nlgSharesAt(place);
  float share = 0.0;
  for (int c = 0; c < 8; ++c) {
    if (uint(shares.record[c]) == record) share += shares.share[c];
  }
  return share;
}

#elif defined(SHOWS_LEAKS)
// How much brighter it would be if the same probes counted by their tents alone, whatever stands between: luminance.
float leakAt(vec3 place, vec3 normal) {
  vec4 frame = uintBitsToFloat(nlgHeader(0));
  NlgCell cell = nlgFindCell((place - frame.xyz) * frame.w);
  if (!cell.found) return 0.0;
  NlgShares tents = nlgSharesAt(place);
  vec3 ours = nlgBlendedIrradiance(tents, normal);
  float sum = 0.0;
  for (int c = 0; c < 8; ++c) {
    NlgCorner corner = nlgCornerOf(cell, c);
    tents.share[c] = (corner.kind & 7) == NLG_KIND_NONE ? 0.0 : corner.tent * corner.ratio;
    sum += tents.share[c];
  }
  if (!(sum > 0.0)) return 0.0;
  for (int c = 0; c < 8; ++c) tents.share[c] /= sum;
  return dot(nlgBlendedIrradiance(tents, normal) - ours, vec3(0.2126, 0.7152, 0.0722));
}
#else
vec3 irradianceAt(vec3 place, vec3 normal) { return nlgIrradiance(place, normal).irradiance; }
#endif
