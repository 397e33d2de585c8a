#include "engine.hpp"

namespace peers {
namespace {

/// An engine, or an empty list where it was left out.
struct Peer {
  std::string name;
  Engine (*make)();
};

const std::vector<Peer> peers{
#ifdef PEERS_BOX2D
    {"Box2D", box2d},
#else
    {"Box2D", nullptr},
#endif
#ifdef PEERS_CHIPMUNK
    {"Chipmunk", chipmunk},
#else
    {"Chipmunk", nullptr},
#endif
#ifdef PEERS_MUJOCO
    {"MuJoCo", mujoco},
#else
    {"MuJoCo", nullptr},
#endif
#ifdef PEERS_SIMBODY
    {"Simbody", simbody},
#else
    {"Simbody", nullptr},
#endif
#ifdef PEERS_IDA
    {"SUNDIALS IDA", ida},
#else
    {"SUNDIALS IDA", nullptr},
#endif
};

}  // namespace

std::vector<Engine> engines() {
  std::vector<Engine> all{this_solver(), dense()};
  for (const Peer& peer : peers)
    if (peer.make != nullptr) all.push_back(peer.make());
  return all;
}

std::vector<std::string> missing_engines() {
  std::vector<std::string> names;
  for (const Peer& peer : peers)
    if (peer.make == nullptr) names.push_back(peer.name);
  return names;
}

}  // namespace peers
