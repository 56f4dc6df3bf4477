% Responses at a parameter set, by Kriging.
function predicted = predict_responses (models, points, responses, p)
  predicted = zeros (1, numel (models));
  for number = 1:numel (models)
    known = responses(:, number);
    predicted(number) = stk_predict (models{number}, points, known, p').mean;
  end
end
