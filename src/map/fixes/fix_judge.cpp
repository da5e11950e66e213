#include "map/fixes/fix_judge.h"

#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

// A receiver that has found its satellites again may be metres off for so long, s; and an outage
// is so long, at least.
constexpr double kConverges = 30.0, kOutage = 3.0;
constexpr double kTold = 2.0;  // s; STATUS comes once a second
// So many fixes over so many metres make a session whole: enough for a distance and an angle beyond
// what errors of a metre's path leave. Or two over so many seconds, as of a robot at rest.
constexpr std::size_t kWhole = 3;
constexpr double kWholeMetres = 1.0, kWholeSeconds = 5.0;
constexpr double kPairMetres = 10.0;  // so far apart, two fixes agree by no chance
// Trusted fixes give way to others, which contradict them, of so many times their weight: which
// side of a jump is right, nothing tells, so the earlier one stays until it is clearly outnumbered.
constexpr double kOutweighs = 3.0;

// The newest of a row, then half as far back from the end to the beginning, and so on: some of all
// ages.
std::vector<std::size_t> of_all_ages(std::size_t count) {
  std::vector<std::size_t> chosen;
  for (std::size_t back = 1; back <= count; back *= 2) chosen.push_back(count - back);
  if (count > 0 && chosen.back() != 0) chosen.push_back(0);
  return chosen;
}

}  // namespace

// With the newest ones; older ones show a drag.
bool FixJudge::follows(const Session& session, std::size_t fix, const ScaleKnown& scale) const {
  const std::vector<std::size_t>& members = session.members;
  std::size_t tried = 0, agreeing = 0;
  for (auto last = members.rbegin(); last != members.rend() && tried < 3; ++last, ++tried)
    if (agree(all_[*last], all_[fix], scale)) ++agreeing;
  return 2 * agreeing > tried;
}

// Whether the fix agrees with an older one, and with the way there from one half as old.
bool FixJudge::agrees(const std::vector<std::size_t>& members, std::size_t i, std::size_t fix,
                      const ScaleKnown& scale) const {
  const Anchor& older = all_[members[i]];
  return agree(older, all_[fix], scale) &&
         (i == 0 || agree(all_[members[i / 2]], older, all_[fix], scale));
}

bool FixJudge::drags(const Session& session, std::size_t fix, const ScaleKnown& scale) const {
  const std::vector<std::size_t>& members = session.members;
  std::size_t against = 0;
  for (const std::size_t i : of_all_ages(members.size()))
    if (!agrees(members, i, fix, scale)) ++against;
  return against >= 2;
}

// Whether the fix contradicts nothing but the first members of a session that began with an outage.
bool FixJudge::converges(const Session& session, std::size_t fix, const ScaleKnown& scale) const {
  const std::vector<std::size_t>& members = session.members;
  if (!session.after_outage) return false;
  const TimeNs settled = all_[members.front()].mark.time() + from_seconds(kConverges);
  const auto later = std::partition_point(
      members.begin(), members.end(), [&](std::size_t i) { return all_[i].mark.time() < settled; });
  return all_[fix].mark.time() < settled + from_seconds(kConverges) &&
         std::all_of(later, members.end(),
                     [&](std::size_t i) { return agree(all_[i], all_[fix], scale); });
}

// Leaves what is older than the newest member that the fix contradicts. What follows that one was
// dragged along, and begins a session of its own. Only after an outage it is the older part that
// was wrong.
void FixJudge::cut(std::size_t session, std::size_t fix, const ScaleKnown& scale) {
  std::vector<std::size_t>& members = sessions_[session].members;
  std::size_t left = 1;
  for (std::size_t i = members.size(); i-- > 1;) {
    if (agrees(members, i, fix, scale)) continue;
    left = i + 1;
    break;
  }
  Session dragged;
  if (converges(sessions_[session], fix, scale)) {
    dragged.trusted = sessions_[session].trusted;
    sessions_[session].trusted = false;
  }
  dragged.members.assign(members.begin() + static_cast<std::ptrdiff_t>(left), members.end());
  dragged.members.push_back(fix);
  members.resize(left);
  sessions_.push_back(std::move(dragged));
}

bool FixJudge::is_whole(const Session& session) const {
  const Anchor& first = all_[session.members.front()];
  const Anchor& last = all_[session.members.back()];
  if (first.quality == FixQuality::kSurveyed) return true;
  const double metres = last.mark.travelled() - first.mark.travelled();
  if (session.members.size() >= 2 && metres >= kPairMetres) return true;
  const double seconds = to_seconds(last.mark.time() - first.mark.time());
  if (session.members.size() >= 2 && seconds >= kWholeSeconds) return true;  // as at rest
  return session.members.size() >= kWhole && metres >= kWholeMetres;
}

double FixJudge::weight(const Session& session) const {
  const Anchor& first = all_[session.members.front()];
  const Anchor& last = all_[session.members.back()];
  return static_cast<double>(session.members.size()) + last.mark.travelled() -
         first.mark.travelled();
}

bool FixJudge::consistent(const Session& a, const Session& b, const ScaleKnown& scale) const {
  const Session& longer = weight(a) > weight(b) ? a : b;
  const Session& other = &longer == &a ? b : a;
  for (const std::size_t fix : {other.members.front(), other.members.back()}) {
    // The longer one up to it, or, if it came first, that one as a whole.
    const auto next = std::upper_bound(longer.members.begin(), longer.members.end(), fix);
    const auto count = static_cast<std::size_t>(next - longer.members.begin());
    for (const std::size_t i : of_all_ages(count))
      if (!agrees(longer.members, i, fix, scale)) return false;
    if (count > 0) continue;
    for (const std::size_t later : {longer.members.front(), longer.members.back()})
      if (!agree(all_[fix], all_[later], scale)) return false;
  }
  return true;
}

void FixJudge::judge(std::size_t number, const ScaleKnown& scale) {
  double against = 0.0;
  bool any = false;
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    if (!sessions_[i].trusted || i == number) continue;
    any = true;
    if (!consistent(sessions_[number], sessions_[i], scale)) against += weight(sessions_[i]);
  }
  const bool whole = is_whole(sessions_[number]);
  if (against == 0.0) {
    sessions_[number].trusted = any || whole;
  } else if (whole && weight(sessions_[number]) > kOutweighs * against) {
    for (std::size_t i = 0; i < sessions_.size(); ++i)
      if (i != number && sessions_[i].trusted &&
          !consistent(sessions_[number], sessions_[i], scale))
        sessions_[i].trusted = false;
    sessions_[number].trusted = true;
  }
}

// That a fix may go on, the newest first. From one fix to the next the odometry hardly errs; with a
// session of long ago it would agree wherever it is.
std::vector<std::size_t> FixJudge::open_sessions(TimeNs now) const {
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < sessions_.size(); ++i)
    if (to_seconds(now - all_[sessions_[i].members.back()].mark.time()) <= kOutage)
      open.push_back(i);
  std::sort(open.begin(), open.end(), [this](std::size_t a, std::size_t b) {
    return sessions_[a].members.back() > sessions_[b].members.back();
  });
  return open;
}

void FixJudge::add(const Anchor& anchor, const ScaleKnown& scale) {
  const std::size_t fix = all_.size();
  all_.push_back(anchor);
  const bool begins =
      fix == 0 || to_seconds(anchor.mark.time() - all_[fix - 1].mark.time()) > kOutage;
  for (const std::size_t i : open_sessions(anchor.mark.time())) {
    if (!follows(sessions_[i], fix, scale)) continue;
    if (drags(sessions_[i], fix, scale)) {
      if (sessions_[i].trusted)
        tell(converges(sessions_[i], fix, scale) ? FixTrouble::kConverged : FixTrouble::kDrag,
             anchor.mark.time());
      cut(i, fix, scale);
      return;
    }
    sessions_[i].members.push_back(fix);
    if (!sessions_[i].trusted) judge(i, scale);
    tell(sessions_[i].trusted || !is_whole(sessions_[i]) ? FixTrouble::kNone : FixTrouble::kJump,
         anchor.mark.time());
    return;
  }
  if (!begins && trouble_ == FixTrouble::kNone) tell(FixTrouble::kJump, anchor.mark.time());
  sessions_.push_back({{fix}, false, begins});
  judge(sessions_.size() - 1, scale);
  if (sessions_.back().trusted) tell(FixTrouble::kNone, anchor.mark.time());
}

// A trouble that is over is told until STATUS has come once.
void FixJudge::tell(FixTrouble trouble, TimeNs now) {
  if (trouble == FixTrouble::kNone && now - told_ < from_seconds(kTold)) return;
  if (trouble != FixTrouble::kNone) told_ = now;
  trouble_ = trouble;
}

std::vector<Anchor> FixJudge::trusted() const {
  std::vector<std::size_t> numbers;
  for (const Session& session : sessions_)
    if (session.trusted)
      numbers.insert(numbers.end(), session.members.begin(), session.members.end());
  std::sort(numbers.begin(), numbers.end());
  std::vector<Anchor> anchors;
  anchors.reserve(numbers.size());
  for (const std::size_t i : numbers) anchors.push_back(all_[i]);
  return anchors;
}

std::size_t FixJudge::refused() const {
  std::size_t count = 0;
  for (const Session& session : sessions_)
    if (!session.trusted) count += session.members.size();
  return count;
}

}  // namespace gprodom
