if(TARGET mv_simulation)
  mv_add_test(unit_time SOURCES unit/time/waveform_test.cpp unit/time/checkpoint_test.cpp unit/chordae/chordae_tension_test.cpp
    unit/chordae/chorda_law_test.cpp unit/time/motion_table_test.cpp LIBRARIES mv_simulation)
endif()
if(TARGET mvsolve AND TARGET mvprep)
  find_package(nlohmann_json REQUIRED)
  mv_add_test(system_mvsolve SOURCES system/mvsolve_test.cpp LIBRARIES mv_core nlohmann_json::nlohmann_json LABEL system)
  add_dependencies(system_mvsolve mvsolve mvprep)
endif()
# mvsolve alone must configure and build where CGAL, gmsh, TetGen, OpenCV and NIfTI cannot be found.
add_test(NAME system_solver_only_build
         COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/../system/solver_only_build.sh ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/solver_only)
set_tests_properties(system_solver_only_build PROPERTIES LABELS system TIMEOUT 1200 PROCESSORS 2)
if(TARGET mvsolve AND TARGET mvprep)
  mv_add_test(regression_closure SOURCES regression/coarse_closure_test.cpp LIBRARIES mv_core nlohmann_json::nlohmann_json LABEL regression)
  add_dependencies(regression_closure mvsolve mvprep)
endif()
