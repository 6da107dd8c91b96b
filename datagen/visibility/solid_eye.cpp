#include "datagen/visibility/solid_eye.h"

#include <algorithm>
#include <array>
#include <bit>

#include "tool/error.h"

namespace nlg {
namespace {

// In the positive octant: near the probe, along each axis in the middle and near the border, and towards the corner.
constexpr std::array<LocalPoint, kEyeCandidateCount / kMirrorCount> kOctantPlaces = {{{0.12f, 0.15f, 0.18f},
                                                                                      {0.50f, 0.15f, 0.20f},
                                                                                      {0.20f, 0.50f, 0.15f},
                                                                                      {0.15f, 0.20f, 0.50f},
                                                                                      {0.50f, 0.45f, 0.40f},
                                                                                      {0.82f, 0.30f, 0.25f},
                                                                                      {0.25f, 0.82f, 0.30f},
                                                                                      {0.30f, 0.25f, 0.82f}}};

// Of so many promising candidates all rays are traced.
constexpr size_t kTracedEyes = 4;

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

template <class Visit>
void forEachMember(uint64_t set, const Visit& visit) {
  for (; set != 0; set &= set - 1) visit(std::countr_zero(set));
}

}  // namespace

const std::vector<uint32_t>& eyeCandidates() {
  static const std::vector<uint32_t> candidates = [] {
    std::vector<uint32_t> points;
    for (const LocalPoint& place : kOctantPlaces) {
      for (uint32_t mirror = 0; mirror < kMirrorCount; ++mirror)
        points.push_back(nearestOctantPoint(place) + mirror * kOctantPointCount);
    }
    return points;
  }();
  return candidates;
}

SolidEye::SolidEye() {
  std::vector<LocalPoint> places;
  for (const uint32_t point : eyeCandidates()) places.push_back(supportPattern().points[point]);
  std::vector<uint64_t> pairs;
  for (uint64_t a = 0; a < places.size(); ++a) {
    for (uint64_t b = a + 1; b < places.size(); ++b) pairs.push_back(a << 32 | b);
  }
  for (const LocalPoint& point : supportPattern().points) tent_.push_back(static_cast<uint64_t>(0x1p32 * double{tent(point)}));
  pairs_ = makeLinkPackets(places, pairs);
  blocked_.resize(pairs_.tree.packetCount());
  visible_.resize(places.size());
}

void SolidEye::findVisible(const SupportVisibility& visibility) {
  blockLinks(pairs_, visibility.triangles(), &scratch_, blocked_.data());
  for (size_t c = 0; c < visible_.size(); ++c) visible_[c] = Set{1} << c;
  for (size_t place = 0; place < pairs_.from_point.size(); ++place) {
    if (blocked_[place / kPacketLanes] >> (place % kPacketLanes) & 1) continue;
    const uint32_t a = pairs_.from_point[place], b = pairs_.to_point[place];
    visible_[a] |= Set{1} << b;
    visible_[b] |= Set{1} << a;
  }
}

// The candidate and all that see it, see those that do, and so on.
SolidEye::Set SolidEye::reachedFrom(int candidate) const {
  Set reached = Set{1} << candidate;
  for (Set added = reached; added != 0;) {
    Set next = 0;
    forEachMember(added, [&](int c) { next |= visible_[c]; });
    added = next & ~reached;
    reached |= next;
  }
  return reached;
}

// What sees each other is in air or in solid together: each such group votes once.
SolidEye::Set SolidEye::inAir(const SupportVisibility& visibility) const {
  Set air = 0, judged = 0;
  std::vector<uint32_t> members;
  for (int c = 0; c < kEyeCandidateCount; ++c) {
    if (judged >> c & 1) continue;
    const Set group = reachedFrom(c);
    judged |= group;
    members.clear();
    forEachMember(group, [&](int member) { members.push_back(eyeCandidates()[member]); });
    if (!visibility.groupVote(members).solid()) air |= group;
  }
  return air;
}

// Candidates that see most of the others, best first; of those that see the same ones only that nearest to the probe, by its tent.
std::vector<int> SolidEye::promising(Set air) const {
  struct Promise {
    uint64_t seen, own;
    int candidate;
  };
  std::vector<Promise> promises;
  forEachMember(air, [&](int candidate) {
    uint64_t seen = 0;
    forEachMember(visible_[candidate] & air, [&](int other) { seen += tent_[eyeCandidates()[other]]; });
    promises.push_back({seen, tent_[eyeCandidates()[candidate]], candidate});
  });
  std::stable_sort(promises.begin(), promises.end(),
                   [](const Promise& a, const Promise& b) { return a.seen != b.seen ? a.seen > b.seen : a.own > b.own; });
  std::vector<int> chosen;
  for (const Promise& promise : promises) {
    const Set sees = visible_[promise.candidate];
    if (std::any_of(chosen.begin(), chosen.end(), [&](int other) { return visible_[other] == sees; })) continue;
    chosen.push_back(promise.candidate);
    if (chosen.size() == kTracedEyes) break;
  }
  return chosen;
}

uint64_t SolidEye::seenTents(const SupportVisibility& visibility) const {
  uint64_t sum = 0;
  for (uint32_t point = 0; point < kSupportPointCount; ++point) sum += visibility.seen(point) ? tent_[point] : 0;
  return sum;
}

std::optional<LocalPoint> SolidEye::open(SupportVisibility* visibility) {
  if (visibility->supportIsEmpty()) return std::nullopt;
  findVisible(*visibility);
  std::optional<LocalPoint> best;
  uint64_t most = 0;
  for (const int candidate : promising(inAir(*visibility))) {
    const LocalPoint& eye = supportPattern().points[eyeCandidates()[candidate]];
    visibility->traceRays(eye);
    const uint64_t seen = seenTents(*visibility);
    if (best && seen <= most) continue;
    best = eye;
    most = seen;
  }
  if (best && visibility->eye() != *best) visibility->traceRays(*best);
  return best;
}

}  // namespace nlg
