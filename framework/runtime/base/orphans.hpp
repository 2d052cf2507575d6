// Processes that a node started by way of another, which has ended: "x &" of system(), the second of "a; b" of popen().
// Nobody waits for them and nobody would know of them: init takes them in. Here this process does.
#pragma once

#include <sys/types.h>

#include <mutex>
#include <string>

namespace plumbline::runtime {

/// A child is being started. Until it is known it would be taken for an orphan, so as long as this lives nobody looks.
class StartOfChild {
 public:
  StartOfChild();
  ~StartOfChild();
  StartOfChild(const StartOfChild&) = delete;
  StartOfChild& operator=(const StartOfChild&) = delete;
  void known(pid_t child) const;
};

/// From now on this process takes in the orphans of all that is started in it. Not if it has children already that it
/// did not start: a shell that had started something became this program (exec), and whose an orphan is nobody could
/// tell.
void take_in_orphans();

/// Ends the orphans that are there, and what they have started. "'sleep' (process 123)", joined by ", "; empty: none
/// goes on. Those of another process group are let be: services, which leave the group they are started in, and what
/// the programs of nodes have started, which is watched where these end.
std::string end_orphans();

/// What system() does, with a shell that is known.
int run_command(const char* command);

/// Whether a command of run_command() goes on, in whichever thread: as long as one does, this process ignores SIGINT
/// and SIGQUIT. None begins or ends while `held` is locked.
bool commands_go_on(std::unique_lock<std::mutex>& held);

}  // namespace plumbline::runtime
