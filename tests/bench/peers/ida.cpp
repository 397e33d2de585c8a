#include <fmt/format.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "engine.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanism.hpp"

namespace peers {
namespace {

using dynamics::World;

/// The equations of the tutorial as a DAE of index 2, after Gear, Gupta and Leimkuhler:
///
///     dq/dt = v + W Jᵀ μ     dv/dt = W (F + Jᵀ λ)     0 = C(q)     0 = J v
///
/// with the rows of the tutorial's joints. The unknowns stand part by part, (q, v) of the part and
/// (λ, μ) of its pin, then those of the rail: the Jacobian of a chain is a band.
class Equations {
 public:
  static constexpr int block = 3 + 3 + 2 + 2;

  explicit Equations(const Model& model) : model_(model), bodies_(start(model)) {}

  int size() const { return block * model_.size() + (model_.rail ? 4 : 0); }
  const State& bodies(const double* y) {
    load(y);
    return bodies_;
  }

  void residual(const double* y, const double* rates, double* out) {
    load(y);
    // What is left of each part's equations without any joint.
    for (int i = 0; i < model_.size(); ++i) {
      const Part& part = model_.parts[static_cast<std::size_t>(i)];
      const std::array<double, 3> mass{part.mass, part.mass, part.inertia};
      const std::array<double, 3> force{0, part.mass * model_.gravity, i == 0 ? model_.torque : 0};
      const int at = block * i;
      for (int k = 0; k < 3; ++k) {
        const auto c = static_cast<std::size_t>(k);
        out[at + k] = mass[c] * (rates[at + k] - y[at + 3 + k]);
        out[at + 3 + k] = mass[c] * rates[at + 3 + k] - force[c];
      }
    }
    for (int i = 0; i < model_.size(); ++i) {
      const Pin& pin = model_.pins[static_cast<std::size_t>(i)];
      const joints::Revolute joint{pin.u1, pin.u2};
      const int at = block * i + 6;
      if (i == 0)
        add(joint.rows(body(i), World{}), i, -1, at, y, out);
      else
        add(joint.rows(body(i), body(i - 1)), i, i - 1, at, y, out);
    }
    const int last = model_.size() - 1;
    if (model_.rail)
      add(joints::Prismatic{}.rows(World{}, body(last)), -1, last, block * (last + 1), y, out);
  }

 private:
  const dynamics::Body& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }

  void load(const double* y) {
    for (dynamics::Body& body : bodies_) {
      body = {{y[0], y[1]}, {y[3], y[4]}, y[2], y[5], dynamics::rotation(y[2])};
      y += block;
    }
  }

  /// A joint of parts `first` and `second`, −1 being the world; its λ and μ stand at `at`.
  template <class Rows>
  static void add(const Rows& rows, int first, int second, int at, const double* y, double* out) {
    std::array<double, 2> Jv{};
    const auto side = [&](const auto& J, int part) {
      const int column = block * part;
      for (int k = 0; k < J.cols(); ++k)
        for (int r = 0; r < 2; ++r) {
          out[column + k] -= J(r, k) * y[at + 2 + r];
          out[column + 3 + k] -= J(r, k) * y[at + r];
          Jv[static_cast<std::size_t>(r)] += J(r, k) * y[column + 3 + k];
        }
    };
    side(rows.J1, first);
    side(rows.J2, second);
    out[at] = rows.C[0], out[at + 1] = rows.C[1];
    out[at + 2] = Jv[0], out[at + 3] = Jv[1];
  }

  Model model_;
  State bodies_;
};

struct Options {
  double absolute = 1;           ///< tolerance, as a multiple of the relative one
  bool algebraic_tested = true;  ///< λ and μ take part in the test of the local error
  double algebraic = 1;          ///< tolerance of λ and μ, as a multiple of the others'
};

void check(int flag, const char* what) {
  if (flag >= 0) return;
  char* const name = IDAGetReturnFlagName(flag);
  const std::string message = fmt::format("{}: {}", what, name);
  std::free(name);
  throw std::runtime_error(message);
}

class IdaRun final : public Run {
 public:
  IdaRun(const Model& model, double accuracy, const Options& options)
      : model_(model), equations_(model), context_(make_context(), free_context) {
    const int n = equations_.size();
    y_ = make_vector(n);
    rates_ = make_vector(n);
    const Owner<std::remove_pointer_t<N_Vector>> differential = make_vector(n);
    set_start();
    for (int i = 0; i < Equations::block * model.size(); ++i)
      N_VGetArrayPointer(differential.get())[i] = i % Equations::block < 6 ? 1.0 : 0.0;

    constexpr int band = 2 * Equations::block - 1;
    if (model.rail) {
      matrix_ = {SUNDenseMatrix(n, n, context_.get()), SUNMatDestroy};
      solver_ = {SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get()), free_solver};
    } else {
      matrix_ = {SUNBandMatrix(n, band, band, context_.get()), SUNMatDestroy};
      solver_ = {SUNLinSol_Band(y_.get(), matrix_.get(), context_.get()), free_solver};
    }
    ida_ = {IDACreate(context_.get()), [](void* memory) { IDAFree(&memory); }};
    // Its own words would be printed; what it returns says as much.
    IDASetErrHandlerFn(
        ida_.get(), [](int, const char*, const char*, char*, void*) {}, nullptr);
    check(IDAInit(ida_.get(), residual, 0.0, y_.get(), rates_.get()), "IDAInit");
    const auto tolerances = make_vector(n);
    for (int i = 0; i < n; ++i)
      N_VGetArrayPointer(tolerances.get())[i] =
          options.absolute * accuracy *
          (N_VGetArrayPointer(differential.get())[i] != 0 ? 1 : options.algebraic);
    check(IDASVtolerances(ida_.get(), accuracy, tolerances.get()), "IDASVtolerances");
    check(IDASetUserData(ida_.get(), &equations_), "IDASetUserData");
    check(IDASetLinearSolver(ida_.get(), solver_.get(), matrix_.get()), "IDASetLinearSolver");
    check(IDASetId(ida_.get(), differential.get()), "IDASetId");
    check(IDASetSuppressAlg(ida_.get(), options.algebraic_tested ? SUNFALSE : SUNTRUE),
          "IDASetSuppressAlg");
    check(IDASetMaxNumSteps(ida_.get(), 10'000'000), "IDASetMaxNumSteps");
    check(IDASetStopTime(ida_.get(), model.duration), "IDASetStopTime");
  }

  void run(double allowed) override {
    const double started = measure::cpu_seconds();
    double t = 0;
    for (long i = 0; t < model_.duration; ++i) {
      check(IDASolve(ida_.get(), model_.duration, &t, y_.get(), rates_.get(), IDA_ONE_STEP),
            "IDASolve");
      if (i % 16 == 0) check_time(started, allowed, t);
    }
  }
  long steps() const override {
    long steps = 0;
    IDAGetNumSteps(ida_.get(), &steps);
    return steps;
  }
  State state() override { return equations_.bodies(N_VGetArrayPointer(y_.get())); }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    for (const Part& part : model_.parts) masses.emplace_back(part.mass, part.inertia);
    return masses;
  }

 private:
  template <class T>
  using Owner = std::unique_ptr<T, void (*)(T*)>;

  static SUNContext make_context() {
    SUNContext context = nullptr;
    SUNContext_Create(nullptr, &context);
    return context;
  }
  static void free_context(std::remove_pointer_t<SUNContext>* context) {
    SUNContext_Free(&context);
  }
  static void free_solver(std::remove_pointer_t<SUNLinearSolver>* solver) { SUNLinSolFree(solver); }
  Owner<std::remove_pointer_t<N_Vector>> make_vector(int n) const {
    N_Vector vector = N_VNew_Serial(n, context_.get());
    N_VConst(0.0, vector);
    return {vector, N_VDestroy};
  }

  static int residual(double, N_Vector y, N_Vector rates, N_Vector out, void* equations) {
    static_cast<Equations*>(equations)->residual(N_VGetArrayPointer(y), N_VGetArrayPointer(rates),
                                                 N_VGetArrayPointer(out));
    return 0;
  }

  /// At rest, with the accelerations and the λ of equation 1, so that the start is consistent.
  void set_start();

  Model model_;
  Equations equations_;
  Owner<std::remove_pointer_t<SUNContext>> context_;
  Owner<std::remove_pointer_t<N_Vector>> y_{nullptr, N_VDestroy}, rates_{nullptr, N_VDestroy};
  Owner<std::remove_pointer_t<SUNMatrix>> matrix_{nullptr, SUNMatDestroy};
  Owner<std::remove_pointer_t<SUNLinearSolver>> solver_{nullptr, free_solver};
  Owner<void> ida_{nullptr, [](void*) {}};
};

void IdaRun::set_start() {
  mechanics::Mechanism mechanism = make_mechanism(model_);
  const Eigen::VectorXd q = mechanism.initial_position(), v = mechanism.initial_velocity();
  Eigen::VectorXd a = v;
  mechanism.acceleration(0.0, q, v, a);
  double *y = N_VGetArrayPointer(y_.get()), *rates = N_VGetArrayPointer(rates_.get());
  for (int i = 0; i < model_.size(); ++i, y += Equations::block, rates += Equations::block)
    for (int k = 0; k < 3; ++k) {
      y[k] = q[3 * i + k];
      rates[3 + k] = a[3 * i + k];
    }
  for (int joint = 0; joint < model_.size() + (model_.rail ? 1 : 0); ++joint) {
    const Eigen::VectorXd lambda = mechanism.evaluation().lambda(mechanism.system.joint(joint));
    double* const at =
        N_VGetArrayPointer(y_.get()) + Equations::block * joint + (joint < model_.size() ? 6 : 0);
    at[0] = lambda[0];
    at[1] = lambda[1];
  }
}

}  // namespace

Engine ida() {
  std::array<char, 64> version{};
  SUNDIALSGetVersion(version.data(), static_cast<int>(version.size()));
  Engine engine{"SUNDIALS IDA", version.data(), {}};
  const auto add = [&](const std::string& name, double first, bool is_default, bool in_chain,
                       const Options& options) {
    engine.settings.push_back({.name = name,
                               .rung = Rung::accuracy,
                               .first = first,
                               .is_default = is_default,
                               .in_chain = in_chain,
                               .start = [=](const Model& model, double accuracy) {
                                 return std::make_unique<IdaRun>(model, accuracy, options);
                               }});
  };
  // IDA has no default tolerance; 1e-4 is what its own examples ask for. For a DAE of index 2 its
  // guide advises to leave the algebraic variables out of the error test.
  const std::string untested = "algebraic variables not tested";
  add(untested, 1e-4, true, true, {.algebraic_tested = false});
  add(untested, 1e-2, false, true, {.algebraic_tested = false});
  add(untested + ", atol = rtol/1000", 1e-2, false, false,
      {.absolute = 1e-3, .algebraic_tested = false});
  for (const double loose : {1e3, 1e6})
    add(fmt::format("{}, their atol {:g} times the others'", untested, loose), 1e-2, false,
        loose == 1e3, {.algebraic_tested = false, .algebraic = loose});
  add("all variables tested", 1e-2, false, false, {});
  return engine;
}

}  // namespace peers
