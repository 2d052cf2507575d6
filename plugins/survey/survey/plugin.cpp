#include "adjust_node.hpp"
#include "brief_node.hpp"
#include "compare_node.hpp"
#include "file_axes_node.hpp"
#include "plan_node.hpp"
#include "series_node.hpp"
#include "simulate_node.hpp"
#include "tables_node.hpp"

using namespace plumbline::survey;

PLUMBLINE_PLUGIN("survey", PLUMBLINE_BUILD_ID, "MIT", AdjustNode, BriefNode, CompareEpochsNode, CheckControlNode,
                 EpochSeriesNode, FileAxesNode, PlanNode, SimulateSurveyNode, TablesNode)
