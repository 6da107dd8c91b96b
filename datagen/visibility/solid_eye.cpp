#include "datagen/visibility/solid_eye.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "datagen/visibility/solid_vote.h"

namespace nlg {
namespace {

// Of so many promising candidates all rays are traced.
constexpr size_t kTracedEyes = 4;

using OctantPlaces = std::array<LocalPoint, kEyeCandidateCount / kMirrorCount>;

// In the positive octant: near the probe, along each axis in the middle and farther out, and towards the corner.
constexpr OctantPlaces kInnerPlaces = {{{0.12f, 0.15f, 0.18f},
                                        {0.50f, 0.15f, 0.20f},
                                        {0.20f, 0.50f, 0.15f},
                                        {0.15f, 0.20f, 0.50f},
                                        {0.50f, 0.45f, 0.40f},
                                        {0.82f, 0.30f, 0.25f},
                                        {0.25f, 0.82f, 0.30f},
                                        {0.30f, 0.25f, 0.82f}}};

// Before each face, two; towards each edge, and the corner.
constexpr OctantPlaces kOuterPlaces = {{{0.94f, 0.20f, 0.25f},
                                        {0.25f, 0.94f, 0.20f},
                                        {0.20f, 0.25f, 0.94f},
                                        {0.94f, 0.60f, 0.25f},
                                        {0.25f, 0.94f, 0.60f},
                                        {0.60f, 0.25f, 0.94f},
                                        {0.65f, 0.70f, 0.68f},
                                        {0.90f, 0.88f, 0.86f}}};

uint32_t nearestOctantPoint(const LocalPoint& place) {
  const std::vector<LocalPoint>& points = supportPattern().points;
  const auto squaredDistance = [&](const LocalPoint& point) {
    const float x = point[0] - place[0], y = point[1] - place[1], z = point[2] - place[2];
    return x * x + y * y + z * z;
  };
  const auto nearest =
      std::min_element(points.begin(), points.begin() + kOctantPointCount,
                       [&](const LocalPoint& a, const LocalPoint& b) { return squaredDistance(a) < squaredDistance(b); });
  return static_cast<uint32_t>(nearest - points.begin());
}

std::vector<uint32_t> candidatesAround(const OctantPlaces& places) {
  std::vector<uint32_t> points;
  for (const LocalPoint& place : places) {
    for (uint32_t mirror = 0; mirror < kMirrorCount; ++mirror)
      points.push_back(nearestOctantPoint(place) + mirror * kOctantPointCount);
  }
  return points;
}

template <class Visit>
void forEachMember(uint64_t set, const Visit& visit) {
  for (; set != 0; set &= set - 1) visit(std::countr_zero(set));
}

// Of a place that is by itself in air.
bool isBehindSky(const SupportVisibility& visibility, const LocalPoint& at) {
  return visibility.rays().hasSkyFaces() && solidVoteWithSky(visibility.rays(), visibility.placeOf(at)).solid();
}

}  // namespace

const std::vector<uint32_t>& eyeCandidates(EyeRing ring) {
  static const std::vector<uint32_t> inner = candidatesAround(kInnerPlaces), outer = candidatesAround(kOuterPlaces);
  return ring == EyeRing::inner ? inner : outer;
}

SolidEye::Candidates::Candidates(EyeRing ring) : points(eyeCandidates(ring)), visible(points.size()) {
  std::vector<LocalPoint> places;
  for (const uint32_t point : points) places.push_back(supportPattern().points[point]);
  std::vector<uint64_t> all;
  for (uint64_t a = 0; a < places.size(); ++a) {
    for (uint64_t b = a + 1; b < places.size(); ++b) all.push_back(a << 32 | b);
  }
  pairs = makeLinkPackets(places, all);
  blocked.resize(pairs.tree.packetCount());
}

void SolidEye::Candidates::findVisible(const SupportVisibility& visibility, LinkScratch* scratch) {
  blockLinks(pairs, visibility.triangles(), scratch, blocked.data());
  for (size_t c = 0; c < visible.size(); ++c) visible[c] = Set{1} << c;
  for (size_t place = 0; place < pairs.from_point.size(); ++place) {
    if (blocked[place / kPacketLanes] >> (place % kPacketLanes) & 1) continue;
    const uint32_t a = pairs.from_point[place], b = pairs.to_point[place];
    visible[a] |= Set{1} << b;
    visible[b] |= Set{1} << a;
  }
}

// The candidate and all that see it, see those that do, and so on.
SolidEye::Set SolidEye::Candidates::reachedFrom(int candidate) const {
  Set reached = Set{1} << candidate;
  for (Set added = reached; added != 0;) {
    Set next = 0;
    forEachMember(added, [&](int c) { next |= visible[c]; });
    added = next & ~reached;
    reached |= next;
  }
  return reached;
}

// What sees each other is in air or in solid together: each such group votes once.
SolidEye::Set SolidEye::Candidates::inAir(const SupportVisibility& visibility) const {
  Set air = 0, judged = 0;
  std::vector<uint32_t> members;
  for (int c = 0; c < kEyeCandidateCount; ++c) {
    if (judged >> c & 1) continue;
    const Set group = reachedFrom(c);
    judged |= group;
    members.clear();
    forEachMember(group, [&](int member) { members.push_back(points[member]); });
    const auto place_of = [&](size_t member) { return visibility.placeOf(supportPattern().points[members[member]]); };
    const SolidVote vote = groupVote(visibility.rays(), members.size(), place_of);
    if (!withCavity(vote, visibility.rays(), place_of(0)).solid()) air |= group;
  }
  return air;
}

SolidEye::SolidEye() : inner_(EyeRing::inner), outer_(EyeRing::outer) {
  for (const LocalPoint& point : supportPattern().points) tent_.push_back(static_cast<uint64_t>(0x1p32 * double{tent(point)}));
  all_tents_ = std::accumulate(tent_.begin(), tent_.end(), uint64_t{0});
}

// The square of the share, by tents, of pairs in a set that see each other.
double SolidEye::onenessOf(const Candidates& candidates, Set set) const {
  // in units of 2^-16 the products of 64 by 64 tents add up exactly
  const auto tentOf = [&](int candidate) { return tent_[candidates.points[candidate]] >> 16; };
  uint64_t all = 0, mutual = 0;
  forEachMember(set, [&](int a) {
    uint64_t seen = 0;
    forEachMember(set & candidates.visible[a], [&](int b) { seen += tentOf(b); });
    all += tentOf(a);
    mutual += tentOf(a) * seen;
  });
  const double share = all > 0 ? static_cast<double>(mutual) / static_cast<double>(all * all) : 0.0;
  return share * share;
}

// Candidates that see most of the others as one, best first; of those that see the same ones only that nearest to the probe, by its
// tent.
std::vector<SolidEye::Promise> SolidEye::promising(const Candidates& candidates, const SupportVisibility& visibility) const {
  const Set air = candidates.inAir(visibility);
  // the tents of what a candidate sees, times how much of it is one
  std::vector<Promise> promises;
  forEachMember(air, [&](int candidate) {
    const Set set = candidates.visible[candidate] & air;
    uint64_t seen = 0;
    forEachMember(set, [&](int other) { seen += tent_[candidates.points[other]]; });
    const double oneness = onenessOf(candidates, set);
    promises.push_back({oneness * static_cast<double>(seen), oneness, tent_[candidates.points[candidate]], candidate});
  });
  std::stable_sort(promises.begin(), promises.end(),
                   [](const Promise& a, const Promise& b) { return a.seen != b.seen ? a.seen > b.seen : a.own > b.own; });
  // different views only: tracing the same one twice would tell nothing
  std::vector<Promise> eyes;
  std::vector<Set> seen_sets;
  for (const Promise& promise : promises) {
    const Set sees = candidates.visible[promise.candidate];
    if (std::find(seen_sets.begin(), seen_sets.end(), sees) != seen_sets.end()) continue;
    // no wall tells what lies behind the sky from what lies before it
    if (isBehindSky(visibility, supportPattern().points[candidates.points[promise.candidate]])) continue;
    seen_sets.push_back(sees);
    eyes.push_back(promise);
    if (eyes.size() == kTracedEyes) break;
  }
  return eyes;
}

uint64_t SolidEye::darkTents(const SupportVisibility& visibility) const {
  uint64_t sum = 0;
  visibility.forEachDark([&](uint32_t point) { sum += tent_[point]; });
  return sum;
}

std::optional<LocalPoint> SolidEye::open(SupportVisibility* visibility) {
  if (visibility->triangles().empty()) return std::nullopt;
  std::optional<LocalPoint> best;
  double most = 0.0;
  for (Candidates* ring : {&inner_, &outer_}) {
    ring->findVisible(*visibility, &scratch_);
    for (const Promise& promise : promising(*ring, *visibility)) {
      const LocalPoint& eye = supportPattern().points[ring->points[promise.candidate]];
      visibility->traceRays(eye);
      const double seen = promise.oneness * static_cast<double>(all_tents_ - darkTents(*visibility));
      if (best && seen <= most) continue;
      best = eye;
      most = seen;
    }
    if (best) break;
  }
  if (best && visibility->eye() != *best) visibility->traceRays(*best);
  return best;
}

}  // namespace nlg
