// The C++ layer over plugin.h: a node is a struct whose members are its ports and parameters.
//
//   struct Shift : plumbline::Node {
//     static constexpr plumbline::Info info{"demo.shift", "", 1, "Moves points along z"};
//     In<Points>     source{"source", frame("frame=?S"), "points to move"};
//     Param<double>  height{"height", 0.0, "m", between(-100, 100), "how far up"};
//     Out<Points>    moved{"points", frame("frame=?S"), "the moved points"};
//     void run(Context&) override {
//       PointsT points = source.unpack();
//       for (auto& point : points.points) point->position.z() += *height;
//       moved.commit(points);
//     }
//   };
//   PLUMBLINE_PLUGIN("demo", "0.1.0", "MIT", Shift)
//
// A node object lives for one run. What run() throws becomes the error of the node; nothing else leaves the plugin.
// Members register themselves with the node under construction, so a line each is all there is to declare.
#pragma once

#include "plumbline/artifact.hpp"
#include "plumbline/failure.hpp"            // BadInput, NotConverged: what run() may throw beside others
#include "plumbline/node/context.hpp"       // Context: log, progress, seed, metrics, files
#include "plumbline/node/declarations.hpp"  // Info, between(), one_of(), frame(), required
#include "plumbline/node/export.hpp"        // PLUMBLINE_PLUGIN
#include "plumbline/node/param.hpp"         // Node::Param
#include "plumbline/node/ports.hpp"         // Node, Node::In, Optional, List, Each, Out, OutList
#include "plumbline/plugin.h"
