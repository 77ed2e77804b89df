if(TARGET mv_study)
  mv_add_test(unit_study_accuracy
    SOURCES unit/study/pareto_test.cpp unit/study/richardson_test.cpp unit/study/study_table_test.cpp unit/study/known_answers_test.cpp unit/study/bench_test.cpp
            unit/time/stress_areas_test.cpp
    LIBRARIES mv_study)
endif()
if(TARGET mvsolve AND TARGET mvprep)
  find_package(nlohmann_json REQUIRED)
  mv_add_test(system_accuracy SOURCES system/accuracy_test.cpp LIBRARIES mv_core nlohmann_json::nlohmann_json LABEL system)
  add_dependencies(system_accuracy mvsolve mvprep)
endif()
