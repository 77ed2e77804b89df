if(TARGET mv_output)
  mv_add_test(unit_output
    SOURCES unit/output/frames_test.cpp unit/output/contact_map_test.cpp unit/output/series_test.cpp unit/output/summary_test.cpp
            support/synthetic_results.cpp
    LIBRARIES mv_output)
endif()
if(TARGET mv_report)
  find_package(ZLIB REQUIRED)
  mv_add_test(unit_report
    SOURCES unit/report/raster_test.cpp unit/report/png_test.cpp unit/report/report_test.cpp unit/report/compare_test.cpp unit/report/compare_reference_test.cpp support/synthetic_results.cpp
    LIBRARIES mv_report ZLIB::ZLIB)
  add_executable(make_synthetic_results ${CMAKE_CURRENT_LIST_DIR}/../support/make_synthetic_results.cpp
                                        ${CMAKE_CURRENT_LIST_DIR}/../support/synthetic_results.cpp)
  set_target_properties(make_synthetic_results PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  target_link_libraries(make_synthetic_results PRIVATE mv_options mv_test_support mv_report)
  add_test(NAME system_report_browser
           COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/../system/report_browser.sh $<TARGET_FILE:make_synthetic_results>)
  set_tests_properties(system_report_browser PROPERTIES LABELS system TIMEOUT 300 SKIP_RETURN_CODE 77)
endif()
