if(TARGET mv_pipeline)
  find_package(nlohmann_json REQUIRED)
  find_package(VTK REQUIRED COMPONENTS IOXML CommonCore CommonDataModel)
  mv_add_test(unit_pipeline
    SOURCES unit/pipeline/manifest_test.cpp unit/pipeline/input_files_test.cpp unit/pipeline/case_directory_test.cpp unit/pipeline/runner_test.cpp unit/pipeline/prediction_test.cpp
            unit/pipeline/source_file_test.cpp unit/pipeline/export_case_test.cpp
            unit/pipeline/layout_rules_test.cpp unit/pipeline/interrupt_test.cpp unit/pipeline/tube_stage_test.cpp unit/pipeline/deck_settings_test.cpp
    LIBRARIES mv_pipeline VTK::IOXML VTK::CommonDataModel)
  mv_add_test(system_mvprep SOURCES system/mvprep_test.cpp LIBRARIES mv_core nlohmann_json::nlohmann_json LABEL system)
  add_dependencies(system_mvprep mvprep)
  mv_add_test(system_annulus_files SOURCES system/annulus_files_test.cpp LIBRARIES mv_core LABEL system)
  add_dependencies(system_annulus_files mvprep)
  mv_add_test(system_layout SOURCES system/layout_test.cpp LIBRARIES mv_core LABEL system)
  add_dependencies(system_layout mvprep mvsolve)
endif()
