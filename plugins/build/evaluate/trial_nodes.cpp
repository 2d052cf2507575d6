// What trials and plans are evaluated by (errors, poses, bounds, what was withheld), in a plugin of its own: who judges
// a building builds nothing of it.
#include "build/evaluate/crlb_node.hpp"
#include "build/evaluate/crossval_nodes.hpp"
#include "build/evaluate/errors_node.hpp"
#include "build/evaluate/image_plan_node.hpp"
#include "build/evaluate/poses_node.hpp"
#include "build/evaluate/surface_errors_node.hpp"
#include "plumbline/node.hpp"

PLUMBLINE_PLUGIN("evaluate_trials", PLUMBLINE_BUILD_ID, "MIT", plumbline::judgement::EvaluateErrors,
                 plumbline::judgement::EvaluatePoses, plumbline::judgement::EvaluateCrlb,
                 plumbline::judgement::PlanImages, plumbline::judgement::EvaluateWithhold,
                 plumbline::judgement::EvaluateLengths, plumbline::judgement::EvaluateSurfaces)
