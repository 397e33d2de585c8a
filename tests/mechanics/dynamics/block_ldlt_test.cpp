// The set-up of the block factor: the order of elimination against one found by looking at every
// node each time, and what it costs for long chains and for many joints on one thing.
#include "mechanics/dynamics/block_ldlt.hpp"

#include <cmath>
#include <ctime>
#include <set>

#include "catch.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/revolute.hpp"
#include "random.hpp"

using namespace dynamics;
using Cliques = std::vector<std::vector<int>>;

namespace {

int random_int(int n) { return std::uniform_int_distribution<int>(0, n - 1)(generator); }
std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// The place of each node in the order: least neighbours, then touched longest ago, then first.
/// blocks: those of the factor.
std::vector<int> reference(int n, const Cliques& cliques, int& blocks) {
  std::vector<std::set<int>> neighbours(index(n));
  for (const auto& clique : cliques)
    for (int i : clique)
      for (int j : clique)
        if (i != j) neighbours[index(i)].insert(j);
  std::vector<int> position(index(n), -1), touched(index(n));
  blocks = 0;
  for (int step = 0; step < n; ++step) {
    int next = -1;
    const auto key = [&](int i) {
      return std::pair(neighbours[index(i)].size(), touched[index(i)]);
    };
    for (int i = 0; i < n; ++i)
      if (position[index(i)] < 0 && (next < 0 || key(i) < key(next))) next = i;
    position[index(next)] = step;
    const std::set<int> left = neighbours[index(next)];
    blocks += 1 + static_cast<int>(left.size());
    for (int j : left) {
      touched[index(j)] = step + 1;
      neighbours[index(j)].insert(left.begin(), left.end());
      neighbours[index(j)].erase(j);
      neighbours[index(j)].erase(next);
    }
  }
  return position;
}

void check_order(int n, const Cliques& cliques) {
  std::vector<int> size(index(n), 2);
  BlockLdlt K;
  K.analyse(size, cliques);
  int blocks = 0, differ = 0;
  const std::vector<int> position = reference(n, cliques, blocks);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      differ += K.after(i, j) != (position[index(i)] > position[index(j)]);
  CHECK(differ == 0);
  CHECK(K.blocks() == blocks);
}

/// The joints on each thing of a chain of n links on the world; of a closed one.
Cliques chain(int n, bool closed) {
  Cliques things;
  for (int i = 0; i + 1 < n; ++i) things.push_back({i, i + 1});
  things.push_back(closed ? std::vector{n - 1, 0} : std::vector{n - 1});
  return things;
}

double seconds(const std::function<void()>& f) {
  double least = INFINITY;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();  // of the processor: others may be at work
    f();
    least = std::min(least, double(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

/// n particles of 1 kg on rods of 1 m around a hub, turning about it at omega.
struct Hub {
  double mass = 3, omega = 2;
  int n;
  System s;
  Handle<Particle> hub = s.add_particle("hub", mass, {0, 0});

  explicit Hub(int arms) : n(arms) {
    for (int i = 0; i < n; ++i) {
      const std::string number = std::to_string(i);
      const auto p = s.add_particle("p" + number, 1, arm(i), omega * S(arm(i)));
      s.add("rod" + number, joints::Distance{1}, hub, p);
    }
  }
  Vector2d arm(int i) const { return rotation(2 * std::acos(-1.0) * i / n).col(0); }
};

}  // namespace

TEST_CASE("the order of elimination is the one found by looking at every node") {
  for (const int n : {1, 2, 3, 4, 5, 10, 33, 100}) {
    check_order(n, chain(n, false));
    if (n > 1) check_order(n, chain(n, true));
    std::vector<int> all(index(n));
    for (int i = 0; i < n; ++i) all[index(i)] = i;
    check_order(n, {all});  // a hub
    check_order(n, {});
  }
  for (int k = 0; k < 300; ++k) {  // scenes: each joint on two things, some on the world
    const int n = 1 + random_int(60), things = 1 + random_int(k % 3 == 0 ? 5 : n);
    Cliques cliques(index(things));
    for (int i = 0; i < n; ++i) {
      const int a = random_int(things), b = random_int(things + 2);
      cliques[index(a)].push_back(i);
      if (b < things && b != a) cliques[index(b)].push_back(i);
    }
    check_order(n, cliques);
  }
  for (int k = 0; k < 100; ++k) {  // nodes of any number of cliques
    const int n = 1 + random_int(30);
    Cliques cliques(index(random_int(n)));
    for (auto& clique : cliques)
      for (int i = 0; i < n; ++i)
        if (random_int(n) < 3) clique.push_back(i);
    check_order(n, cliques);
  }
}

TEST_CASE("the set-up of a chain takes time in proportion to its length") {
  for (const bool closed : {false, true}) {
    const auto analyse = [&](int n) {
      BlockLdlt K;
      K.analyse(std::vector<int>(index(n), 2), chain(n, closed));
      CHECK(K.blocks() == (closed ? 3 * n - 3 : 2 * n - 1));
    };
    const double ratio = seconds([&] { analyse(100'000); }) / seconds([&] { analyse(10'000); });
    CHECK(ratio < 40);  // 10 for the length, the logarithm, the caches; in quadratic time 100
  }
  // A whole scene, put together by name, with its forces.
  const auto scene = [](int n) {
    System s;
    Handle<Body> last;
    for (int i = 0; i < n; ++i) {
      const std::string number = std::to_string(i);
      const auto link = s.add_body("link" + number, 1, 1, {i + 0.5, 0});
      if (i > 0) s.add("pin" + number, joints::Revolute{{-0.5, 0}, {0.5, 0}}, link, last);
      s.apply(link, {0, 0, 1});
      last = link;
    }
    Evaluation e(s);
    s.evaluate(0, s.initial_q(), s.initial_v(), e);
    CHECK(e.counts().factor_blocks == 2 * (n - 1) - 1);
  };
#ifdef __SANITIZE_ADDRESS__
  const int n = 4'000;  // each allocation is made anew there, and copied
#else
  const int n = 40'000;
#endif
  CHECK(seconds([&] { scene(n); }) < 40 * seconds([&] { scene(n / 10); }));
}

TEST_CASE("what fades along a chain fades to zero, past no number that slows a processor down") {
  // x_{i-1} + 4 x_i + x_{i+1} = b_i with a load at one end: x_i = -(2 - sqrt 3) x_{i-1}.
  const int n = 1000;
  Cliques cliques;
  for (int i = 1; i < n; ++i) cliques.push_back({i - 1, i});
  BlockLdlt K;
  K.analyse(std::vector<int>(index(n), 1), cliques);
  for (int i = 0; i < n; ++i) {
    K.K()[K.block(i, i)] = 4;
    if (i > 0) K.K()[K.after(i, i - 1) ? K.block(i, i - 1) : K.block(i - 1, i)] = 1;
  }
  K.factor();
  for (const bool at_front : {true, false}) {
    Eigen::VectorXd x = Eigen::VectorXd::Unit(n, at_front ? 0 : n - 1);
    K.solve(x);
    if (!at_front) x.reverseInPlace();
    int numbers = 0, wrong = 0;
    for (int i = 0; i < n; ++i) {
      numbers += x[i] != 0;
      wrong += x[i] != 0 && !(std::abs(x[i]) > 1e-150);
      const double expected = std::pow(std::sqrt(3.0) - 2, i + 1) * -1;
      wrong += std::abs(x[i] - expected) > 1e-12 * std::abs(expected) + 1e-139;
    }
    CHECK(wrong == 0);
    CHECK(numbers > 240);
    CHECK(numbers < 250);
  }
}

TEST_CASE("many joints on one thing are solved as long as their factor fits") {
#ifdef NDEBUG
  const int n = 1000;  // its factor's n^3/6 updates take 0.7 GB
#else
  const int n = 100;
#endif
  Hub scene(n);
  const Vector2d F(70, -30);
  scene.s.apply(scene.hub, F);
  Evaluation e(scene.s);
  scene.s.evaluate(0, scene.s.initial_q(), scene.s.initial_v(), e);
  CHECK(e.counts().factor_blocks == n * (n + 1) / 2);
  // Each rod hands on what pulls along it: the sum of e e^T is n/2, and the centripetal pulls
  // cancel.
  const Vector2d a = F / (scene.mass + n / 2.0);
  CHECK((e.a().head<2>() - a).norm() < 1e-10 * a.norm());
  double error = 0;
  for (int i = 0; i < n; ++i) {
    const Vector2d arm = scene.arm(i);
    const Vector2d a_i = (arm.dot(a) - scene.omega * scene.omega) * arm;
    error = std::max(error, (e.a().segment<2>(2 * i + 2) - a_i).norm());
  }
  CHECK(error < 1e-10);
}

TEST_CASE("a factor that would not fit is refused, and the thing with the most joints named") {
  for (const int n : {2000, 20'000}) {
    const Hub scene(n);
    const std::string words =
        "hub: the factor of J W J^T would take more than 2000 MB; most joints, " +
        std::to_string(n) + ", are on this thing";
    CHECK_THROWS_WITH(Evaluation(scene.s), words);
    CHECK_THROWS_AS(Evaluation(scene.s), std::invalid_argument);
  }
  // One that was laid out before the thing grew is refused each time, and tells nothing.
  Hub scene(10);
  Evaluation e(scene.s);
  scene.s.evaluate(0, scene.s.initial_q(), scene.s.initial_v(), e);
  for (int i = 0; i < 2000; ++i) {
    const std::string number = std::to_string(i);
    scene.s.add("more" + number, joints::Distance{1}, scene.hub,
                scene.s.add_particle("m" + number, 1, {1, 0}));
  }
  for (int i = 0; i < 2; ++i) {
    CHECK_THROWS_AS(scene.s.evaluate(0, scene.s.initial_q(), scene.s.initial_v(), e),
                    std::invalid_argument);
    CHECK_THROWS_AS(e.a(), std::logic_error);
  }
}
