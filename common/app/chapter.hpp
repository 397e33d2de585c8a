#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/options.hpp"
#include "instruments/measure/cases.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "mechanics/motion/motion.hpp"

namespace app {

/// An option to try, "--by length", beside or, alone, in place of what helps every scene.
struct Cure {
  std::string option = {};
  bool alone = false;
};

/// Everything that the shared program needs to know of a chapter. The functions read the scene
/// through the variables that the parameters point to, so they are called after the command line
/// was read.
struct Chapter {
  std::string directory;  ///< "01_particle_on_curve_implicit"
  std::string title;      ///< "Particle on a curve, implicit"

  std::vector<Parameter> parameters;
  std::vector<Text> texts;  ///< what else the scene is chosen by; the window keeps it
  measure::RunOptions defaults;
  bool has_constraints = true;        ///< false: nothing to stabilize, and no such options
  std::string constraint_unit = "m";  ///< of C

  /// The fastest turning [rad/s] that the scene can come to as its parameters stand. Empty: every
  /// scene bears the default step.
  std::function<double()> fastest;

  /// What helps a run of the scene, as its parameters stand, that is far from right. Empty: what
  /// helps every scene.
  std::function<Cure()> cure;

  /// The scene at t = 0 under a method.
  measure::Start start;

  /// What is compared with the exact answer, and the errors of a row, one for each quantity; none
  /// at all for a scene without an exact answer.
  std::vector<measure::Quantity> quantities;
  measure::Errors errors;

  /// The methods, steps and duration of `report`.
  measure::Ladder ladder;
  /// The scene in one coordinate, without its constraints, and the methods by which `report`
  /// measures it beside the others; empty for a scene that has none.
  struct {
    measure::Start start;
    measure::Errors errors;
    std::vector<mechanics::Method> methods;
  } one_coordinate;
  /// Said under its plot: why the curves end as they do.
  std::string remark = "Where a curve turns flat, rounding is all that is left.";
  /// What `report` of all methods measures besides: writes its files into the folder and prints
  /// their names.
  std::function<void(const std::filesystem::path& out)> also_report;
  /// Sets what `report` needs where the reader has left it at its default.
  std::function<void()> before_report;

  /// The stiff and extreme cases of `stability`; empty for a scene that has none, and no command.
  std::function<measure::Stability()> stability;

  /// The pictures of the lesson; empty for a scene that has none, and no `snapshot`.
  std::function<std::vector<pictures::Picture>(const measure::RunOptions&)> pictures;
  /// The scene at its start, ready to move and to be looked at.
  std::function<std::unique_ptr<pictures::Stage>(const measure::RunOptions&)> stage;
};

/// The step [s] where none is given: the chapter's own, or a tenth of a radian of a scene that
/// turns faster, but a million steps at most in `duration` seconds.
double default_step(const Chapter& chapter, double duration);

/// The program of a chapter: `run`, `snapshot`, `report`, `stability`. Returns the exit status: 0
/// on success, 2 on unusable arguments, 1 when the work could not be finished; both with one line
/// on standard error.
int run_chapter(int argc, char** argv, const Chapter& chapter);

}  // namespace app
