% Finite differences of the residuals as nonlin_residmin makes them by itself: two-sided, 0.1 % of
% each parameter to either side, one-sided at a bound. The runs are asked for together, so that
% they happen in parallel; by itself it makes them one after the other.
function slopes = residual_slopes (p, f, settings)
  lower = settings.lower(:);
  upper = settings.upper(:);
  n = numel (p);
  step = settings.difference * abs (p);
  points = zeros (0, n);
  for k = 1:n
    below = p;
    above = p;
    below(k) = max (p(k) - step(k), lower(k));
    above(k) = min (p(k) + step(k), upper(k));
    if (p(k) > lower(k))
      points(end + 1, :) = below';
    end
    if (p(k) < upper(k))
      points(end + 1, :) = above';
    end
  end
  responses = request_runs (points, "differences");
  slopes = zeros (numel (f), n);
  row = 0;
  for k = 1:n
    low = f;
    high = f;
    from = p(k);
    to = p(k);
    if (p(k) > lower(k))
      row += 1;
      low = residuals (points(row, :)', responses(row, :), settings);
      from = points(row, k);
    end
    if (p(k) < upper(k))
      row += 1;
      high = residuals (points(row, :)', responses(row, :), settings);
      to = points(row, k);
    end
    slopes(:, k) = (high - low) / (to - from);
  end
end
