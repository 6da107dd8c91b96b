/* A door that opens between a lit room and a dark one: the probes around it get new weighting functions from 1024 rays each, at run time.
 *
 *   moving_door WEIGHTS.safetensors [PICTURE.pgm]
 *
 * WEIGHTS must read samples. For the door closed, ajar and open it prints what theta of all probes took, rays and network apart, and how far
 * the blended light is from that of exact visibility. The picture shows both in a slice 1.2 m above the floor: exact above, predicted below. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "nlg/nlg.h"

enum { kSamples = 1024, kAlong = 6, kAcross = 6, kUp = 4, kProbes = kAlong * kAcross * kUp, kPixels = 160 };

typedef struct {
  double x, y, z;
} Point;
typedef struct {
  Point low, high;
} Box;

/* A wall in the plane x = 0 with a doorway 1 m wide and 2 m high, and its door with the hinge at y = -0.5. */
static const Box kWalls[3] = {{{-0.06, -9, 0}, {0.06, -0.5, 3}}, {{-0.06, 0.5, 0}, {0.06, 9, 3}}, {{-0.06, -0.5, 2}, {0.06, 0.5, 3}}};
static const Box kDoor = {{-0.03, -0.5, 0}, {0.03, 0.5, 2}};
static double door_angle = 0.0; /* 0: closed; radians */

static Point inDoor(Point p) {
  const double c = cos(door_angle), s = sin(door_angle), y = p.y + 0.5;
  const Point turned = {c * p.x - s * y, s * p.x + c * y - 0.5, p.z};
  return turned;
}

static int isInside(Box box, Point p) {
  return p.x > box.low.x && p.x < box.high.x && p.y > box.low.y && p.y < box.high.y && p.z > box.low.z && p.z < box.high.z;
}

static int meets(Box box, Point from, Point to) {
  const double low[3] = {box.low.x, box.low.y, box.low.z}, high[3] = {box.high.x, box.high.y, box.high.z};
  const double start[3] = {from.x, from.y, from.z}, step[3] = {to.x - from.x, to.y - from.y, to.z - from.z};
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (fabs(step[axis]) < 1e-12) {
      if (start[axis] < low[axis] || start[axis] > high[axis]) return 0;
      continue;
    }
    double a = (low[axis] - start[axis]) / step[axis], b = (high[axis] - start[axis]) / step[axis];
    if (a > b) { const double swap = a; a = b, b = swap; }
    enter = fmax(enter, a), leave = fmin(leave, b);
  }
  return enter <= leave;
}

static int isSolid(Point p) {
  for (int w = 0; w < 3; ++w) {
    if (isInside(kWalls[w], p)) return 1;
  }
  return p.z < 0 || isInside(kDoor, inDoor(p));
}

static int isSeen(Point from, Point to) {
  for (int w = 0; w < 3; ++w) {
    if (meets(kWalls[w], from, to)) return 0;
  }
  return to.z >= 0 && !meets(kDoor, inDoor(from), inDoor(to));
}

/* Probes a metre apart; those on the side x < 0 are lit. */
static Point probeAt(int n) {
  const Point p = {n % kAlong - 2.55, n / kAlong % kAcross - 2.6, n / (kAlong * kAcross) - 0.6 + 0.3};
  return p;
}

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static void lookAround(const float* points, uint8_t* seen, uint8_t* valid) {
  memset(seen, 0, kProbes * kSamples / 8), memset(valid, 0, kProbes * kSamples / 8);
  for (int n = 0; n < kProbes; ++n) {
    const Point probe = probeAt(n);
    for (int i = 0; i < kSamples; ++i) {
      const float* local = points + 3 * nlg_sample_point((size_t)i);
      const Point p = {probe.x + local[0], probe.y + local[1], probe.z + local[2]};
      if (isSolid(p)) continue;
      const int byte = n * kSamples / 8 + i / 8;
      valid[byte] |= (uint8_t)(1 << i % 8);
      if (isSeen(probe, p)) seen[byte] |= (uint8_t)(1 << i % 8);
    }
  }
}

/* Light at p, by functions of theta, or by exact visibility where theta is null; -1 where nothing weighs. */
static double lightAt(Point p, const nlg_generator* generator, const float* theta, nlg_scratch* scratch) {
  double sum = 0.0, weights = 0.0;
  for (int n = 0; n < kProbes; ++n) {
    const Point probe = probeAt(n);
    const float x = (float)(p.x - probe.x), y = (float)(p.y - probe.y), z = (float)(p.z - probe.z);
    if (fabsf(x) >= 1 || fabsf(y) >= 1 || fabsf(z) >= 1 || isSolid(probe)) continue;
    float weight = (1 - fabsf(x)) * (1 - fabsf(y)) * (1 - fabsf(z)) * (float)isSeen(probe, p);
    if (theta != NULL) nlg_evaluate(generator, theta + (size_t)n * nlg_theta_count(generator), 1, &x, &y, &z, &weight, scratch);
    weights += weight, sum += weight * (probe.x < 0);
  }
  return weights > 1e-4 ? sum / weights : -1.0;
}

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) return fprintf(stderr, "usage: moving_door WEIGHTS.safetensors [PICTURE.pgm]\n"), 2;
  static const char* const kStates[3] = {"closed", "ajar", "open"};
  static const double kAngles[3] = {0.0, 0.35, 1.5};
  static uint8_t seen[kProbes * kSamples / 8], valid[kProbes * kSamples / 8], picture[2 * kPixels][3 * kPixels];
  nlg_generator* generator;
  nlg_scratch* scratch;
  const float* points;
  uint64_t hash;
  char why[256];
  const nlg_status loaded = nlg_generator_load(argv[1], &generator, why, sizeof why);
  if (loaded != NLG_OK) return fprintf(stderr, "%s (%s)\n", why, nlg_status_name(loaded)), 3;
  if (!nlg_reads_samples(generator)) {
    nlg_generator_free(generator);
    return fprintf(stderr, "%s: expected weights that read samples\n", argv[1]), 3;
  }
  float* theta = malloc(kProbes * nlg_theta_count(generator) * sizeof(float));
  if (theta == NULL || nlg_scratch_create(generator, NULL, &scratch) != NLG_OK || nlg_support_pattern(&points, &hash) != NLG_OK) return 1;
  for (int state = 0; state < 3; ++state) {
    door_angle = kAngles[state];
    const double start = seconds();
    lookAround(points, seen, valid);
    const double looked = seconds();
    nlg_generate_from_samples(generator, seen, valid, kProbes, theta, scratch);
    const double done = seconds();
    double error = 0.0;
    int count = 0;
    for (int row = 0; row < kPixels; ++row) {
      for (int column = 0; column < kPixels; ++column) {
        const Point p = {4.0 * (column + 0.5) / kPixels - 2.0, 2.0 - 4.0 * (row + 0.5) / kPixels, 1.2};
        const double exact = isSolid(p) ? -1.0 : lightAt(p, NULL, NULL, NULL);
        const double predicted = isSolid(p) ? -1.0 : lightAt(p, generator, theta, scratch);
        picture[row][state * kPixels + column] = (uint8_t)(exact < 0 ? 90 : 255 * exact);
        picture[kPixels + row][state * kPixels + column] = (uint8_t)(predicted < 0 ? 90 : 255 * fmin(1.0, predicted));
        if (exact >= 0 && predicted >= 0) error += fabs(exact - predicted), ++count;
      }
    }
    printf("%s: %d probes, rays %.2f ms, network %.2f ms, mean error of light %.4f\n", kStates[state], kProbes, 1e3 * (looked - start),
           1e3 * (done - looked), error / count);
  }
  if (argc == 3) {
    FILE* file = fopen(argv[2], "wb");
    if (file == NULL) return fprintf(stderr, "%s: cannot be written\n", argv[2]), 5;
    fprintf(file, "P5 %d %d 255\n", 3 * kPixels, 2 * kPixels);
    fwrite(picture, 1, sizeof picture, file);
    if (fclose(file) != 0) return fprintf(stderr, "%s: cannot be written\n", argv[2]), 5;
  }
  free(theta);
  nlg_scratch_free(scratch);
  nlg_generator_free(generator);
  return 0;
}
