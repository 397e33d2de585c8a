// The main function of all tests, with Catch2 version 2 or 3.
#define CATCH_CONFIG_RUNNER
#include <cstdlib>

#include "catch.hpp"
#include "random.hpp"

namespace {

struct Seed : Catch::EventListenerBase {
  using Catch::EventListenerBase::EventListenerBase;
  void testCaseStarting(const Catch::TestCaseInfo&) override {
    generator.seed(random_seed);
    std::srand(random_seed);  // Eigen's
  }
};

}  // namespace

CATCH_REGISTER_LISTENER(Seed)

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int status = session.applyCommandLine(argc, argv); status != 0) return status;
  // What checks nothing has not passed: no case of that name, or a case without an assertion.
  session.configData().warnings =
      static_cast<Catch::WarnAbout::What>(Catch::WarnAbout::NoAssertions | no_such_case);
  // Catch2 2 exits with the number of failed checks, and to Catch2 3's discovery 4 is a skip.
  return session.run() == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
