// One order to one robot of VDA 5050, to its end, whatever the broker and this program go through: lost, late, double
// and reordered messages, a broker that goes away, a kill at any moment. Nothing is lost, nothing is asked for twice.
//
// What makes it so: (1) a state message is a whole, it tells of every action of the robot's order, so that the next one
// makes up for any that was lost; (2) before an order is sent, and before it is sent again, the robot is asked
// (`stateRequest`) and must have answered that it does not have it, after it was asked and itself: what a broker has
// kept of it is no answer; (3) what is about to be sent is on disk before it
// is sent, what came is on disk before anything is concluded from it; (4) an order that is sent again is the same, byte
// for byte but its header's number, and a robot takes the same orderId and orderUpdateId as the order that it has; (5)
// an order that a broker holds back expires before another one is sent; (6) a robot that was started again since an
// order was sent may have done it and forgotten: then nothing is sent, and a person is asked to measure.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "loop/exchange/vda5050.hpp"

namespace plumbline::loop {

struct MqttMessage {
  std::string topic, payload;
  double expires = 0;  ///< after so many seconds the broker drops it; 0: never
};

/// What must outlive the program: two append-only files of JSON lines, each line on disk when append returns.
class ExchangeLog {
 public:
  virtual ~ExchangeLog() = default;
  virtual void append_sent(const std::string& line) = 0;
  virtual void append_state(const std::string& line) = 0;
  virtual std::vector<std::string> sent() const = 0;
  virtual std::vector<std::string> states() const = 0;
  /// Why the job is not to be sent: a later round went on from its own, or items of it were given to robots other than
  /// `robot` (MANUFACTURER/SERIAL), or to it in another order, and were not reported since. In words with what to do;
  /// empty: nothing, and with `take` its items are this robot's, on disk when it returns.
  virtual std::string held_by_others(const Job& job, const std::string& robot, bool take) {
    return static_cast<void>(job), static_cast<void>(robot), static_cast<void>(take), std::string();
  }
  /// The robot has the job, whoever sent it: its items are that robot's, on disk when it returns.
  virtual void note_given(const Job& job, const std::string& robot) {
    static_cast<void>(job), static_cast<void>(robot);
  }
};

/// sent.jsonl and states.jsonl in a folder that is made. A torn last line, of a program that was killed, is cut off.
/// One program at a time: a second one is refused. `given`: the file that says which robot has which items, shared by
/// the programs of all robots (a line each: item, revision, robot, order); empty: nobody asks. `rounds`: the folder of
/// the round that made the job, whose journal and whose neighbours tell what was reported since, and whether a later
/// round counts; empty: not known. Throws std::runtime_error with path and reason.
class ExchangeFolder : public ExchangeLog {
 public:
  explicit ExchangeFolder(const std::string& folder, const std::string& given = "", const std::string& rounds = "");
  ~ExchangeFolder() override;
  ExchangeFolder(const ExchangeFolder&) = delete;
  ExchangeFolder& operator=(const ExchangeFolder&) = delete;
  void append_sent(const std::string& line) override;
  void append_state(const std::string& line) override;
  std::vector<std::string> sent() const override;
  std::vector<std::string> states() const override;
  std::string held_by_others(const Job& job, const std::string& robot, bool take) override;
  void note_given(const Job& job, const std::string& robot) override;

 private:
  std::string folder_, given_, rounds_;
  int sent_ = -1, states_ = -1;
};

struct ExchangeTimes {
  double answer = 5;    ///< a robot that was asked has so long before it is asked again [s]
  double expiry = 60;   ///< of an order at the broker [s]
  double silence = 30;  ///< an order under way of which nothing was heard for so long is asked for [s]
};

enum class ExchangeStatus {
  asking,    ///< the robot has not answered yet
  busy,      ///< it has another order that is not at its end
  sent,      ///< the order is on its way
  accepted,  ///< the robot has it
  finished,  ///< all actions are FINISHED or FAILED, and on disk
  rejected,  ///< the robot does not take it: reason()
  unknown    ///< nobody knows what became of it: reason()
};
const char* name_of(ExchangeStatus status);

class OrderExchange {
 public:
  /// `robot.header_id` and `robot.timestamp` are not used. Takes up what `log` says of this order; a job of a lower
  /// revision than another one that `log` has sent is rejected (unknown, if it was sent before that). Throws what
  /// vda_order() throws.
  OrderExchange(const Job& job, const VdaRobot& robot, ExchangeLog& log, const ExchangeTimes& times = {});

  std::string state_topic() const { return vda_topic(robot_, "state"); }
  /// What is to be published now, at `now` [s] on any clock that does not go back, also not from start to start, and
  /// `utc` on that of the calendar (ISO 8601). What is returned counts as sent.
  std::vector<MqttMessage> due(double now, const std::string& utc);
  /// A message of state_topic(), `is_kept`: that the broker had retained, of a robot that may be off. What is no state
  /// message of this robot changes nothing.
  void on_state(const std::string& payload, double now, bool is_kept = false);
  /// The broker is back: what was asked before is asked again.
  void on_connect() { asked_ = false; }

  ExchangeStatus status() const { return status_; }
  bool is_over() const { return status_ >= ExchangeStatus::finished; }
  const std::string& reason() const { return reason_; }
  /// Actions in each state as the robot told last: "3 FINISHED, 1 RUNNING".
  std::string progress() const { return progress_; }
  /// What its states' dates say of its clock, in words; empty: nothing.
  std::string clock_doubt() const;
  /// Items of the job that the robot says FAILED of.
  const std::vector<std::string>& failed() const { return failed_; }

 private:
  enum class Heard { now, kept, on_disk };
  void take(const std::string& payload, Heard heard, double now);
  /// Whether a state with an older date than the newest is newer all the same: the robot's clock was put back.
  bool goes_on_by_number(double seconds, long long header, double now);
  /// The robot has our order: how far it is with each action, and whether that was the end.
  void take_progress(const std::map<std::string, std::string>& actions, bool is_at_its_end);
  /// The robot does not have it any more, and nobody knows how far it came.
  void lose_order();
  void restore_sent();
  void refuse_old_revision();
  void refuse_items_of_others(bool take);
  MqttMessage question(const std::string& utc);
  MqttMessage order(double now, const std::string& utc);

  Job job_;
  VdaRobot robot_;
  ExchangeLog& log_;
  ExchangeTimes times_;
  ExchangeStatus status_ = ExchangeStatus::asking;
  std::string reason_, progress_, last_actions_;
  std::vector<std::string> failed_;
  bool is_noted_ = false;                  ///< that the robot has it: ExchangeLog::note_given
  bool asked_ = false, answered_ = false;  ///< since start, connection or the last order
  double asked_at_ = 0, heard_at_ = 0, sent_at_ = -1;
  std::string other_order_;  ///< the last that was sent and is not this one
  double other_sent_at_ = -1e300;
  long long header_ = 0, header_at_sending_ = -1;
  double newest_ = -1e300;  ///< timestamp of the newest state [s]
  long long newest_header_ = -1;
  /// Of states whose numbers go on behind the newest one's, and whose dates do not: the last, and how many in a row.
  double behind_seconds_ = -1e300;
  long long behind_header_ = -1;
  int behind_ = 0;
  int question_number_ = 0, order_number_ = 0;
  int newest_revision_ = 0;  ///< of other jobs that were sent
};

}  // namespace plumbline::loop
