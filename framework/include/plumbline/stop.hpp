// Places where long work can be stopped: a library asks there whether anybody still waits for its result.
//
// The host's `cancelled()` belongs to the node, and a solver knows no node. So the node's run opens a StopScope, once
// and in one place (node/export.hpp), and loops that may take long call stop_point(), which costs a look at an atomic.
// It is of the thread that opened the scope: work that is handed to other threads is stopped where their results are
// gathered.
#pragma once

namespace plumbline {

/// The work was stopped, because nobody waits for it any more. Not a failure, and so no std::exception: who catches
/// those to go on lets it pass.
class Stopped {};

/// Within it, stop_point() of this thread asks `asked`. Scopes nest; the innermost counts.
class StopScope {
 public:
  using Question = bool (*)(const void* of);
  StopScope(Question asked, const void* of) : before_(current()) { current() = {asked, of}; }
  ~StopScope() { current() = before_; }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

  /// Whether the work should end; false outside of any scope.
  static bool is_asked_for() { return current().asked && current().asked(current().of); }

 private:
  struct Entry {
    Question asked = nullptr;
    const void* of = nullptr;
  };
  static Entry& current() {
    static thread_local Entry entry;
    return entry;
  }
  Entry before_;
};

/// Throws Stopped if the work should end.
inline void stop_point() {
  if (StopScope::is_asked_for()) throw Stopped();
}

}  // namespace plumbline
