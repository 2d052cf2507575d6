#include "join_node.hpp"
#include "layout_node.hpp"
#include "nodes.hpp"
#include "readings_nodes.hpp"

using namespace plumbline::survey_files;

PLUMBLINE_PLUGIN("survey_files", PLUMBLINE_BUILD_ID, "MIT", ReadGsi, ReadLandXml, ReadJobXml, ReadSdr33, ReadRw5,
                 ReadZeiss, ReadNikon, ReadTopconGts7, ReadTopconGts210, ReadTopconLevel, ReadGeodimeter, ReadIdx,
                 ReadStarNet, ReadDynaMl, ReadGama, ReadKrumm, ReadSurveyCsv, ReadSetupCoordinates, ReadSurvey,
                 ReadLayout, WriteGsi, WriteLandXml, WriteGama, WriteStarNet, WriteSurveyCsv, JoinSurveys,
                 FileForReader, CollectReadings)
