// Runs a check on every SIMD target of this build and machine, one after another.
#pragma once

#include <gtest/gtest.h>

#include "nlg/simd.h"

namespace nlg {

template <class Check>
void forEachTarget(const Check& check) {
  const std::string before(chosenSimdTarget());
  for (const std::string_view target : availableSimdTargets()) {
    ASSERT_EQ(forceSimdTarget(target), SimdStatus::ok) << target;
    SCOPED_TRACE(target);
    check();
  }
  ASSERT_EQ(forceSimdTarget(before), SimdStatus::ok) << before;
}

}  // namespace nlg
