// simulate.@name@: a model of a robot; stands in for simulate.robots (robots.use=simulate.@name@).
//
// Write into work() what your robot does to an item of a job, with its errors, and what it says of it. Jobs, the site
// and reports are read and written as by every robot.
#include "build/loop/robot_node.hpp"
#include "geometry/random.hpp"

using namespace plumbline;
using namespace plumbline::loop;

namespace {

struct Robot : RobotNode {
  static constexpr Info info{"simulate.@name@", "robot", 1, "A robot with one error for all that it does"};
  Param<double> sigma{"sigma", 0.0004, "m", between(0, 0.1), "of each setting and direction, and of what it measures"};

 protected:
  Deed work(const Job& todo, std::size_t item, std::uint64_t seed) override {
    const JobItem& wanted = todo.items[item];
    Random own(seed, "item " + wanted.id);
    Deed deed = asked(wanted);
    if (wanted.kind == "bracket")
      deed.moved += own.normal3(*sigma);
    else
      deed.measured = todo.origin + wanted.target + own.normal3(*sigma + 1e-4);  // it sees what it has hung
    return deed;
  }
  RobotErrors errors(const Job&) const override { return {*sigma, 0}; }  // what a plan has to take of it
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Robot)
