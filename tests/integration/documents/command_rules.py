"""How each command of the pages is typed in the folder that test_commands.py prepares. The first rule whose regular expression is the
whole line holds; what it says is typed in place of the line (None: the line itself). Simulated sites get few and small photographs,
benches one seed; everything else is as the page has it."""
TAGS = "detector=aruco family=DICT_6X6_1000"
SMALL = "floors=2 columns=2 camera=quick_6mp site.with.images_per_floor=4"
SMALL_OF = {"single_floor": "columns=2 camera=quick_6mp site.with.images_per_floor=4"}
ROUND = "first=true now=2026-05-05T08:00:00Z measured=2026-05-04T08:00:00Z"
RENDERED = "--seeds 1 --out out/rendered"
# NOT HERE: a test of its own types it, named by its file. SERVED: runs until its page is there, is looked at, and is stopped.
WHERE, SERVED = "NOT HERE: ", "SERVED: "


def rules(data):
    aicon = f"plumbline run image_block folder={data}/blocks/aicon"
    return [
        # Names that pages use, where a line is run as it stands otherwise.
        (r"plumbline (new|watch|bench|run|run --rehash|run --isolate|serve|schema|list|describe|doctor|help|cache)", r"plumbline \1 --help"),
        (r"plumbline bench FILE", "plumbline bench quick --seeds 1 --out out/quick"),
        (r"plumbline new (TEMPLATE|survey_reader) NAME", "plumbline new survey_reader mine --out NEW"),
        (r"plumbline new (planner|robot) NAME", r"plumbline new \1 mine --out NEW"),
        (r"plumbline new pose_solver plane", "plumbline new pose_solver plane --out NEW"),
        (r"(plumbline (?:describe|doctor|validate|plan|graph|verify|verify --each)) (KIND|FILE|PIPELINE)", None),
        (r"PLUMBLINE_PLUGIN_PATH=build/lib/plumbline plumbline run …", WHERE + "tests/integration/installed/new_nodes.sh builds and runs it"),
        (r"plumbline describe demo.lift", WHERE + "tests/integration/installed/outside_plugin.sh builds and describes it"),
        (r"plumbline serve (out.*)", SERVED + r"plumbline serve out --port 0"),
        (r"plumbline watch site_campaign .*", "plumbline watch site_campaign folder=site --out out/watched --quiet-for 0.1 --runs 1"),
        (r"plumbline watch PIPELINE", "plumbline watch read_survey file=job.gsi --out out/watched_survey --quiet-for 0.1 --runs 1"),
        (r"plumbline-robots .*", WHERE + "wants a broker and robots: tests/integration/robots/broker_test.sh has both"),
        (r"plumbline run site_loop \.\.\. (reports.with.states=)\S+ (reports.with.jobs=)\S+",
         "plumbline run site_loop folder=site state=rounds/0/state.json now=2026-05-06T08:00:00Z measured=2026-05-05T10:00:00Z "
         r"\1[states.jsonl] \2[rounds/0/job.json] --out rounds/3"),
        # Sites.
        (r"plumbline run site_campaign folder=june (epoch=\S+ before=out/may/as_built.json)", r"plumbline run site_campaign folder=site \1"),
        (r"plumbline run site_surfaces folder=\S+(.*)", r"plumbline run site_surfaces folder=small"),
        (r"plumbline run site_photographs folder=\S+", "plumbline run site_photographs folder=alone frames.with.datum_sigma=0.005"),
        (r"plumbline run site_survey_scan .*", WHERE + "tests/integration/cli/test_building.cpp scans its panels and runs it"),
        (r"(plumbline run (?:site_campaign|site_survey|survey_campaign|site_campaign_joint)) folder=\S+(.*?)( --out \S+)?", r"\1 folder=site\2"),
        (r"plumbline run plan_installation folder=\S+ 'deviation.with.held_below=.*", "plumbline run plan_installation folder=observed "
         "'deviation.with.held_below=[\"class=IfcPlate: sigma=0.5mm, sill_sigma=0.5mm\"]' 'deviation.with.sills=[\"name~R1$\"]'"),
        (r"plumbline run (site_observations|plan_installation) folder=\S+(.*)", r"plumbline run \1 folder=observed\2"),
        (r"plumbline run site_loop folder=(\S+) first=true(.*)", f"plumbline run site_loop folder=site {ROUND} --out rounds/1"),
        (r"plumbline run site_loop folder=tuesday .*",
         "plumbline run site_loop folder=site state=rounds/1/state.json now=2026-05-06T08:00:00Z measured=2026-05-05T10:00:00Z --out rounds/2"),
        (r"plumbline run site_loop_photographs .*", f"plumbline run site_loop_photographs folder=site {ROUND}"),
        (r"plumbline run epoch_series .*", "plumbline run epoch_series folder=epochs movements.with.days=[0,30,61]"),
        (r"plumbline campaign (init|check) \S+", r"plumbline campaign check site"),
        # Surveys.
        (r'plumbline run survey_network file=job.gsi "network.with.exclude=.*',
         'plumbline run survey_network file=job.gsi "network.with.exclude=[point F01-C03-R2: knocked over, line job.gsi:46: read twice]"'),
        (r"plumbline run survey_network file=job.gsi (map=EPSG:25832.*)", r"plumbline run survey_network file=map.gsi \1"),
        (r"plumbline run (?:pipelines/)?(survey_network|read_survey)(?:\.yaml)? file=(?:…|FILE|job\.gsi)(.*?)( --out OUT)?", r"plumbline run \1 file=job.gsi\2"),
        (r"plumbline run survey_network", "plumbline run survey_network file=job.gsi"),
        (r"plumbline run compare_epochs before=a.gsi after=b.gsi.*", "plumbline run compare_epochs before=job.gsi after=later.gsi"),
        (r"plumbline run (.*)file=docs/examples/(.*)", None),
        (r"plumbline run (\S+) (before=docs/examples/.*)", None),
        (r"plumbline run plan_survey file=layout.csv.*", "plumbline run plan_survey file=docs/examples/survey_plan.csv"),
        (r"plumbline show out --relative F01-C01-R1 F03-C04-R2", None),
        (r"plumbline show (…:block.points|RUN/run.jsonl:NODE.PORT)", "plumbline show network/run.jsonl:network.points"),
        (r"plumbline why NODE( \[RUN\])?", "plumbline why network network"),
        (r"plumbline diff RUN RUN.*", "plumbline diff network network --tolerance 1e-9"),
        (r"plumbline export RUN --format (trace|ro-crate)( > \S+)?", r"plumbline export network --format \1"),
        (r"plumbline journal .*", "plumbline journal executed --check"),
        (r"plumbline cache prune.*", "plumbline cache prune --keep 200GiB --days 3000"),
        (r"plumbline run outlier_search .*", "plumbline run outlier_search points=points.csv control=points.csv"),
        # Photographs: those of a public board, and points that were surveyed on it.
        (r"plumbline run photo_campaign folder=\S+(.*)", f"plumbline run photo_campaign folder=board {TAGS}"),
        (r"plumbline run photo_surfaces folder=\S+", f"plumbline run photo_surfaces folder=board {TAGS}"),
        (r"plumbline run detect_images .*", f"plumbline run detect_images folder=board {TAGS}"),
        (r"plumbline run marker_board .*", f"plumbline run marker_board folder=board {TAGS} tag_size=0.0375"),
        (r"plumbline run calibrate_camera folder=\S+ board=\S+(.*?)( --out OUT)?", r"plumbline run calibrate_camera folder=board board=board.yaml\1"),
        (r"plumbline run marker_field .*",
         f"plumbline run marker_field folder=board {TAGS} layout=known/tags.json camera=known_camera/camera.yaml tag_size=0.0375"),
        (r"plumbline run measure_targets .*", "plumbline run measure_targets folder=board places=clicked.csv"),
        (r"plumbline run colmap_control .*?( block\.with\.pixel_origin=corner)?",
         r"plumbline run colmap_control model=known/sparse control=points.csv observations=measured.csv\1"),
        (r"plumbline run colmap_targets .*", "plumbline run colmap_targets model=painted_model control=painted.csv observations=pointed.csv photographs=painted"),
        (r"plumbline run sfm_control .*",
         "plumbline run sfm_control photographs=few control=points.csv observations=measured.csv sfm.with.max_features=1500"),
        (r"plumbline run image_block folder=blocks/aicon", aicon),
        (r'plumbline run image_block folder=… (project|control)=.*|plumbline run image_block(?: folder=… "block.with.free=\[\]")?',
         f'{aicon} "block.with.free=[]"'),
        (r"plumbline run read_design file=building.ifc", "plumbline run read_design file=site/design.ifc"),
        # Scans.
        (r"plumbline run scan_surfaces (?:scan=\S+) (?:design=\S+)(.*)", r"plumbline run scan_surfaces scan=scan.las design=small/design.ifc\1"),
        (r"plumbline run scan_planes scan=SCAN.las (.*)", r"plumbline run scan_planes scan=scan.las \1"),
        # Simulated sites.
        (r"plumbline run full_height (surfaces=on .*)", r"plumbline run full_height SMALL \1 floors=1"),
        (r"plumbline run (?:pipelines/)?(full_height|full_height_free|single_floor)(?:\.yaml)?(?: camera=quick_6mp)?((?: (?!--out|seed=|camera=)\S+)*)( --out \S+| seed=…)?",
         r"plumbline run \1 SMALL\2"),
        (r"plumbline run building (shape=\S+|language=de units=in)", r"plumbline run building \1 floors=1"),
        (r"plumbline run execution_loop", "plumbline run execution_loop floors=2 --out executed"),
        (r"plumbline run facade_surfaces", "plumbline run facade_surfaces columns=2 rows=1 photographs=4 plain=0 glass=0 pitch=0.1"),
        (r"plumbline graph full_height --format mermaid", None),
        (r"plumbline run (plan_images|observations).*", None),
        # Benches.
        (r"plumbline bench quick --out out/quick --archive supplement", "plumbline bench quick --seeds 1 --out out/quick --archive supplement"),
        (r"plumbline bench verify supplement folder=/mnt/site .*", WHERE + "tests/integration/bench/test_bench.cpp says where inputs and programs lie"),
        (r"plumbline bench verify (\S+).*", "plumbline bench verify supplement --cells 4"),
        (r"plumbline bench (quick|benchmarks/paper/quick.yaml)( --out out/quick)?", r"plumbline bench \1 --seeds 1 --out out/quick"),
        (r"plumbline bench benchmarks/crossval.yaml folder=…", "plumbline bench benchmarks/crossval.yaml folder=site --seeds 1-2 --out out/crossval"),
        (r"plumbline bench rendered (--scenario .*) --seeds 1-4", rf"plumbline bench rendered \1 {RENDERED}"),
        (r"plumbline bench (benchmarks/paper/rendered.yaml).*",
         rf'plumbline bench \1 --scenario "single floor" --scenario "JPEG quality 50" {RENDERED}'),
        (r"plumbline bench (benchmarks/paper/detectors.yaml).*", rf'plumbline bench \1 --scenario ideal {RENDERED}'),
        (r"plumbline bench (benchmarks/surfaces/depth_kinds.yaml).*",
         r"plumbline bench \1 --seeds 1 site.with.width=500 site.with.height=340 --out out/kinds"),
        (r"plumbline bench (benchmarks/\S+\.yaml).*", r"plumbline bench \1 --seeds 1 --out out/paper"),
    ]


# Parameters that a line of a page has and its command here does not, by the pipeline.
DROPPED = {
    "site_loop": ({"reports.with.json", "reports.with.hilti", "reported_at"}, "reports of robots and tools: tests/integration/loop"),
    "image_block": ({"project", "control", "block.use", "files.with.image_size"}, "blocks of others that may not be shipped: tests/golden"),
}
# What ends with another exit code than 0, and is right to: a measurement or a judgement that is no result (3).
OTHER_ENDS = {
    "plumbline run plan_survey file=docs/examples/survey_plan.csv": 3,  # upper floors hang on one shared marker: what the page mends
    "plumbline run plan_survey file=docs/examples/survey_plan.csv --out out/plan": 3,
    "plumbline run site_surfaces folder=small": 3,  # four photographs measure too few points of a panel
    "plumbline run facade_surfaces columns=2 rows=1 photographs=4 plain=0 glass=0 pitch=0.1": 3,
    f"plumbline run full_height {SMALL} surfaces=on scaffold=3 floors=1": 3,
    "plumbline run observations floors=1 depth_distortion=0.1": 3,
}

# Lines that call something else than the program: scripts, and programs of the benchmarks, which -DPLUMBLINE_BENCHMARKS=ON builds
# (scripts/test does). PROGRAMS/: where programs are built. In a build without such a program its line is held to the words that the program
# takes (words_of_programs.py), as every line here and every span that names such a program is.
OTHERS = [
    (r"scripts/(build_times|demo|test|setup|package)\b.*", WHERE + "builds this tree: .ci/run and scripts/test"),
    (r"(cmake|ninja|ctest|build/tests/test_survey)\b.*", WHERE + "builds this tree: scripts/setup and scripts/test"),
    (r"scripts/mutate --(build|run)\b.*", WHERE + "hours in this tree: tests/integration/documents/test_mutate.py types it in a small one"),
    (r"scripts/mutate --table \S+", "scripts/mutate --table mutants.jsonl"),
    (r"/usr/bin/python3 -m pip install .*", WHERE + "tests/integration/python/package.sh"),
    (r"benchmarks/calibration/calibration_sets.py .*",
     "benchmarks/calibration/calibration_sets.py --program PROGRAMS/calibration_benchmark --folder clones --sets calibration_sets.json board"),
    (r"benchmarks/camera_mistakes/camera_mistakes.py .*",
     'benchmarks/camera_mistakes/camera_mistakes.py PROGRAMS/plumbline sets.json --only "every second 5" --table mistakes.md --log said.jsonl'),
    (r"benchmarks/detect/default_detector.py .*", "benchmarks/detect/default_detector.py PROGRAMS/plumbline DICT_6X6_1000 few"),
    (r"benchmarks/ifc/make_large.py .*", "benchmarks/ifc/make_large.py small/design.ifc site/design.ifc 0.1 large.ifc"),
    (r"benchmarks/ifc/run .*", "PROGRAMS/ifc_benchmark large.ifc"),
    (r"benchmarks/site_mistakes/site_mistakes.py .*", WHERE + "tests/site_mistakes/CMakeLists.txt runs it four times"),
    (r"build/bin/detect_benchmark scene .*", "PROGRAMS/detect_benchmark scene scene.jpg tag36h11 1600 1200 9 24 60"),
    (r"build/bin/detect_benchmark (compare tag36h11 scene.jpg --repeat 3|file tag36h11 scene.jpg)", r"PROGRAMS/detect_benchmark \1"),
    (r"build/bin/detect_benchmark (compare DICT_6X6_1000|tag_free tag36h11) PHOTOGRAPHS...", r"PROGRAMS/detect_benchmark \1 few/*.jpg"),
    (r"build/bin/runtime_benchmark .*", "PROGRAMS/runtime_benchmark /dev/shm 100"),
    (r"build/bin/survey_network_benchmark .*", "PROGRAMS/survey_network_benchmark 30 4 6 1"),
    (r"(PLUMBLINE_SHOW=1 )?build/bin/survey_mistakes_benchmark\b.*", r"\1PROGRAMS/survey_mistakes_benchmark 1 feet"),
    (r"build/bin/survey_file_mistakes_benchmark .*", 'PROGRAMS/survey_file_mistakes_benchmark 1 "" 1000001'),
]
