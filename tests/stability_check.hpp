#pragma once

#include <string>

#include "catch.hpp"
#include "instruments/measure/cases.hpp"

/// That every stiff and extreme case of a chapter ends as the chapter says, that its maps agree
/// with theory, and that its long runs grow or stay bounded as expected. All of it in fewer cells
/// and steps than `stability` itself measures and judges; under the sanitizers, which are slow, the
/// maps are coarser still and the long runs are left out.
inline void check_stability(const measure::Stability& stability) {
#ifdef __SANITIZE_ADDRESS__
  constexpr int across = 6;
#else
  constexpr int across = 9;
  const measure::LongRun& run = stability.long_run;
  for (const measure::LongMethod& method : run.methods) {
    const measure::LongCurve curve =
        measure::long_run(*run.start(method.method), method, run.steps / 10, run.step);
    INFO(curve.method << ": " << curve.failure);
    CHECK(curve.bounded() == curve.expected_bounded);
  }
#endif
  for (const measure::Case& trial : stability.cases) {
    const measure::CaseResult verdict = measure::judge(trial);
    INFO(verdict.name << ": expected " << verdict.expected << ", found " << verdict.found);
    CHECK(verdict.as_expected);
  }
  CHECK(!stability.plans.empty());
  for (const measure::Plan& plan : stability.plans) {
    const measure::Map map = measure::measure_map(plan, across);
    INFO(plan.title() << ": " << map.agreeing() << " of " << map.compared());
    CHECK((map.compared() > 0 || across == 6));  // where theory holds for small swings alone
    CHECK(measure::judge(map).as_expected);
  }
}
