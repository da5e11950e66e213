// Which fixes are trusted: those that lie to each other as the odometry says. docs/anchors.md.
#pragma once

#include <cstddef>
#include <vector>

#include "map/fixes/anchor.h"

namespace gprodom {

// What is wrong with the newest fixes.
enum class FixTrouble {
  kNone,
  kJump,       // they contradict those before
  kConverged,  // after an outage the first ones were off
  kDrag,       // they move away little by little
  kRepeated,   // positions come again
  kSwapped,    // latitude and longitude
  kFar         // from the datum
};

class FixJudge {
 public:
  // In time order.
  void add(const Anchor& anchor, const ScaleKnown& scale);

  // Trusted now, in time order. One that was trusted may be refused later, and the other way round.
  std::vector<Anchor> trusted() const;
  std::size_t refused() const;

  // Of the newest fix.
  FixTrouble trouble() const { return trouble_; }

 private:
  // Fixes in a row that agree with each other.
  struct Session {
    std::vector<std::size_t> members;
    bool trusted = false;
    bool after_outage = false;  // or at the very begin: its first ones may still converge
  };

  std::vector<std::size_t> open_sessions(TimeNs now) const;
  bool follows(const Session& session, std::size_t fix, const ScaleKnown& scale) const;
  bool agrees(const std::vector<std::size_t>& members, std::size_t i, std::size_t fix,
              const ScaleKnown& scale) const;
  bool drags(const Session& session, std::size_t fix, const ScaleKnown& scale) const;
  bool converges(const Session& session, std::size_t fix, const ScaleKnown& scale) const;
  void cut(std::size_t session, std::size_t fix, const ScaleKnown& scale);
  void judge(std::size_t session, const ScaleKnown& scale);
  bool consistent(const Session& a, const Session& b, const ScaleKnown& scale) const;
  bool is_whole(const Session& session) const;
  double weight(const Session& session) const;

  void tell(FixTrouble trouble, TimeNs now);

  std::vector<Anchor> all_;
  std::vector<Session> sessions_;
  FixTrouble trouble_ = FixTrouble::kNone;
  TimeNs told_ = 0;  // time of the last trouble
};

}  // namespace gprodom
