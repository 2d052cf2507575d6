// Pages of one kind of result, in a plugin of their own: who judges a building builds nothing of them.
#include "show/report/calibration_page_node.hpp"
#include "show/report/image_block_page_node.hpp"
#include "show/report/installation_page_node.hpp"
#include "show/report/surface_page_node.hpp"
#include "show/report/survey_page_node.hpp"

PLUMBLINE_PLUGIN("report_pages", PLUMBLINE_BUILD_ID, "MIT", plumbline::report::ReportSurvey,
                 plumbline::report::ReportImageBlock, plumbline::report::ReportModelBlock,
                 plumbline::report::ReportTagBlock, plumbline::report::ReportTargetBlock,
                 plumbline::report::ReportCalibration, plumbline::report::ReportInstallation,
                 plumbline::report::ReportSurfaces)
