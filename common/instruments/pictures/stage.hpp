#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "instruments/draw/canvas.hpp"
#include "instruments/draw/geometry.hpp"
#include "instruments/draw/pen.hpp"
#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "mechanics/motion/motion.hpp"
#include "mechanics/motion/watch.hpp"

namespace pictures {

/// What is drawn besides the things themselves.
struct Show {
  bool forces = true;         ///< of the constraints and the loads
  bool trail = true;          ///< where the scene came from
  bool names = false;         ///< of the things
  bool numbers = true;        ///< axes, and the sizes of the forces
  bool verdict = true;        ///< where the motion so far is far from right, in the caption
  std::string else_say = {};  ///< where it is not, but the whole run is
};

/// A scene in motion that can be looked at: in a picture, in a series of them, in a window. Its
/// steps are all run.step long, and what is remembered of the way is remembered at fixed times, so
/// that a picture at a time does not depend on how the way there was cut. A chapter says in its
/// constructor what moves (`add`) and what must be visible (`begin`), and draws.
class Stage {
 public:
  /// Of one simulation: what strays, |E − E(0)| and |C|.
  struct Errors {
    double energy, constraint;
  };
  struct Sample {
    double t;
    std::vector<draw::Point> marks;  ///< the points whose ways are the trails
    std::vector<Errors> errors;      ///< of each simulation; NaN where none is told
    double force;                    ///< the largest that is drawn [N]
  };

  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const measure::RunOptions& run() const { return run_; }
  double time() const { return simulations_.front().simulation->time(); }

  /// Throws mechanics::Diverged, also where mechanics::Watch does.
  void advance(long steps);
  /// To the step nearest to t; with a tolerance, whose steps are its own, to t itself.
  void advance_to(double t);

  /// Goes on from where another stage of the same scene is, under other loads or another method.
  /// What was remembered stays; the energy error is counted from here.
  void take_over(const Stage& before);

  virtual std::string title() const = 0;
  virtual std::string caption() = 0;
  void draw(draw::Pen& pen, const draw::Rect& area, const Show& show);

  /// What of the motion so far is far from right; nothing while a spring pulls.
  mechanics::Verdict verdict() const;
  /// Whether it has moved for so long that its verdict will not change back: from rest, the energy
  /// error of a method of first order is one part in n of the kinetic energy after n steps.
  bool settled() const { return since_count_ >= 200 || time() >= run_.duration; }

  /// Shows as much as another stage of the same scene, and its forces in the same scale.
  void show_as(const Stage& other);

  /// The last run.duration seconds.
  const std::deque<Sample>& samples() const { return samples_; }
  const std::vector<std::string>& names() const { return names_; }

  /// Takes hold of the thing within reach of a point of the page, as it was last drawn, with a
  /// soft spring between the place that was touched and the pointer. False: there is none.
  bool grip(draw::Point pointer);
  void pull(draw::Point pointer);
  /// Lets go. The spring did work, so the energy error is counted from here.
  void release();
  bool gripped() const { return spring_.has_value(); }

 protected:
  /// A thing as a mouse finds it: a box on one of the canvases, and how it moves [m/s, rad/s]. A
  /// particle's has no size.
  struct Outline {
    draw::Point center, velocity;
    double angle = 0.0, half_width = 0.0, half_height = 0.0, turning = 0.0;
    std::size_t canvas = 0;
  };
  /// How a thing gives way: the whole mass that moves [kg], and that felt at a point of the thing.
  struct Mass {
    double all, at_point;
  };
  /// F = k (to − r) − c ṙ on the point r = x + A u of a thing.
  struct Spring {
    std::size_t thing;
    draw::Point u, to;    ///< [m]: in the thing's own frame, in the world
    double k = 0, c = 0;  ///< [N/m], [N·s/m]
    std::size_t canvas;   ///< where the pointer is
  };

  explicit Stage(measure::RunOptions run);

  /// One of the simulations that show the scene. It stays the chapter's.
  void add(mechanics::Simulation& simulation, std::string name);
  /// After the last `add`: remembers the start.
  void begin(const draw::View& view);

  virtual void draw_scene(draw::Pen& pen, const draw::Rect& area, const Show& show) = 0;
  virtual std::vector<draw::Point> marks() const = 0;
  /// The largest of the forces that are drawn [N].
  virtual double force() = 0;
  virtual std::vector<Outline> outlines() const = 0;
  /// Prepares a thing for the spring.
  virtual Mass hold(std::size_t thing, draw::Point u) = 0;

  /// Once on each canvas, before anything is drawn on it.
  void open(draw::Canvas& canvas, const Show& show);
  /// What can be seen: what `begin` was given, grown as far as the scene has left it.
  const draw::View& view() const { return view_; }
  /// The largest force of the time that is remembered [N], 1 where there was none: arrows are
  /// drawn in proportion to it.
  double largest_force();
  /// Of a simulation, now.
  Errors errors_now(std::size_t simulation) const;
  /// The way of a mark up to now.
  std::vector<draw::Point> trail(std::size_t mark) const;
  const std::optional<Spring>& spring() const { return spring_; }
  /// The force [N] of the spring on what was touched of a thing, now at r and moving with rdot.
  draw::Point spring_force(std::size_t thing, draw::Point r, draw::Point rdot) const;
  /// Whether nothing has happened but the motion from the start: an exact answer still holds.
  bool undisturbed() const { return undisturbed_; }

 private:
  struct Watched {
    mechanics::Simulation* simulation;
    std::unique_ptr<mechanics::Watch> watch;
    double balance;  ///< from which the energy error counts [J]
  };

  void count_from_here();
  /// Steps of one length, then a look at what became of it.
  void advance_all(long steps, double h);
  void remember();
  void draw_spring(draw::Pen& pen) const;

  measure::RunOptions run_;
  long stride_;           ///< steps between two samples
  long until_next_ = 0;   ///< steps to the next of them
  long since_count_ = 0;  ///< steps since the energy error is counted
  std::vector<Watched> simulations_;
  std::vector<std::string> names_;
  std::deque<Sample> samples_;
  draw::View view_{};
  double shown_force_ = 0.0;        ///< of another stage
  std::vector<draw::Lens> lenses_;  ///< of the canvases, as last drawn
  std::optional<Spring> spring_;
  bool undisturbed_ = true;
};

/// The stage as it is, on a page of its own.
void draw_page(draw::Pen& pen, Stage& stage, const Show& show = {});

/// One scene in two ways beside each other, each under its name, in one view and one scale of
/// forces: at time t [s].
Picture beside(std::string name, std::string title, std::unique_ptr<Stage> left,
               std::string left_name, std::unique_ptr<Stage> right, std::string right_name,
               double t, std::string caption, const Show& show = {});

/// The scene at time t [s].
Picture picture_at(std::unique_ptr<Stage> stage, double t, const Show& show = {});

}  // namespace pictures
