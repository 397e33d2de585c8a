#pragma once

#include <optional>
#include <string>

#include "app/chapter.hpp"
#include "app/snapshot.hpp"

namespace app {

/// What the command line asks for, beside the scene's parameters.
struct Request {
  measure::RunOptions run;
  bool integrator_given = false, step_given = false;
  std::optional<mechanics::Stabilization> stabilization;
  mechanics::Stabilization unless_given = mechanics::Stabilization::none;
  std::optional<double> ks, kd, tolerance;
  bool strict = false;
  std::string out = ".";
  Snapshot snapshot;
};

/// A line on standard error; if that cannot be written, there is nobody to tell.
void say(const std::string& text);
/// Says so when the feedback itself is unstable at this step.
void warn_of_gains(const measure::RunOptions& run);

/// Makes the folder of --out; throws UsageError where it cannot be written.
void prepare_folder(const std::string& out);

// What the commands do, once the request is settled; live is in live.hpp.
void run_command(const Chapter& chapter, const Request& request);
void snapshot_command(const Chapter& chapter, const Request& request);
void report_command(const Chapter& chapter, const Request& request);
void stability_command(const Chapter& chapter, const Request& request);

}  // namespace app
